"use strict";
(function () {
  var coarse = window.matchMedia("(pointer: coarse)").matches;
  var waiting = Array.prototype.slice.call(document.querySelectorAll("[data-figure]"));
  var drawn = [];
  var PRINT_PX = 690, PRINT_SMALL_PX = 330, NARROW_PX = 520, ENTRY_PX = 17;

  function draw(place) {
    var figure = JSON.parse(document.getElementById("data-" + place.dataset.figure).textContent);
    // A finger that moves over a figure scrolls the page.
    if (coarse) { figure.layout.dragmode = false; }
    // On a narrow screen the legend has one entry a line: give it room of its own.
    if (place.clientWidth < NARROW_PX && figure.layout.showlegend !== false) {
      var entries = figure.data.filter(function (t) { return t.name && t.showlegend !== false; });
      figure.layout.height += ENTRY_PX * Math.max(0, entries.length - 2);
      place.style.height = figure.layout.height + "px";
    }
    Plotly.newPlot(place, figure.data, figure.layout, {
      responsive: true, displaylogo: false, showTips: false,
      modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"]
    });
    drawn.push(place);
  }
  function next() {
    if (!waiting.length) { document.documentElement.dataset.drawn = "all"; return; }
    draw(waiting.shift());
    window.setTimeout(next, 0);
  }
  function all() {
    while (waiting.length) { draw(waiting.shift()); }
  }
  // Paper is narrower than most screens; what is too wide would be cut off.
  window.addEventListener("beforeprint", function () {
    all();
    drawn.forEach(function (place) {
      var most = place.closest(".small") ? PRINT_SMALL_PX : PRINT_PX;
      if (place.clientWidth > most) {
        place.style.width = most + "px";
        Plotly.relayout(place, { width: most });
      }
    });
  });
  window.addEventListener("afterprint", function () {
    drawn.forEach(function (place) {
      if (place.style.width) {
        place.style.width = "";
        Plotly.relayout(place, { width: null, autosize: true });
      }
    });
  });
  next();
})();
