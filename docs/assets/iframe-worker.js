"use strict";
// The search of pages that are opened from their folder: browsers start no worker there, so the
// worker's program runs in a hidden frame, which takes messages and gives answers as a worker would.
if (location.protocol === "file:") {
  class FrameWorker extends EventTarget {
    constructor(program) {
      super();
      this.frame = document.createElement("iframe");
      this.frame.hidden = true;
      document.body.append(this.frame);
      const page = this.frame.contentDocument;
      page.open(); // a page of its own: the empty first one may still be replaced
      page.write("<!doctype html><title>search</title><body>");
      page.close();
      this.inside = this.frame.contentWindow;
      this.inside.postMessage = (data) => this.tell(this, data);
      const script = page.createElement("script");
      this.ready = new Promise((resolve, reject) => {
        script.onload = resolve;
        script.onerror = () => reject(new Error(`${program} cannot be read`));
      });
      script.src = program;
      page.body.append(script);
    }

    tell(target, data) {
      target.dispatchEvent(new MessageEvent("message", { data: structuredClone(data) }));
    }

    postMessage(data) {
      this.ready.then(() => this.tell(this.inside, data));
    }

    terminate() {
      this.frame.remove();
    }
  }
  window.Worker = FrameWorker;
  window.IFrameWorker = FrameWorker; // by this name the search finds its program's folder
}
