"use strict";
(function () {
  var coarse = window.matchMedia("(pointer: coarse)").matches;
  var waiting = Array.prototype.slice.call(document.querySelectorAll("[data-figure]"));
  var drawn = [];
  var shared = JSON.parse(document.getElementById("switch").textContent);
  var now = shared.own;
  var tongue = shared.language;
  var PRINT_PX = 690, PRINT_HIGH_PX = 385, PRINT_PANEL_PX = 150, PRINT_SMALL_PX = 330, NARROW_PX = 520,
    PAGE_WIDE_PX = 703, PAGE_HIGH_PX = 990, SHEET_LEAST_PX = 700, FIRST_LEAST_PX = 600, SHEET_MOST_PX = 860,
    ENTRY_PX = 20;

  // The look of all figures: white ground, a grid, the legend above.
  var AXIS = { title: { standoff: 8 }, gridcolor: "#E2E2E2", zeroline: false, linecolor: "#999999",
    showgrid: true, showline: true, ticks: "outside", tickcolor: "#999999" };
  var LOOK = { layout: {
    font: { family: "system-ui, Segoe UI, Helvetica, Arial, sans-serif", size: 13, color: "#222222" },
    paper_bgcolor: "white", plot_bgcolor: "white", modebar: { orientation: "v" },
    legend: { orientation: "h", x: 0, y: 1.01, yanchor: "bottom", maxheight: 0.9, tracegroupgap: 0,
      font: { size: 12 } },
    hovermode: "closest", hoverlabel: { align: "left" }, xaxis: AXIS, yaxis: AXIS
  } };

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
    // A low panel has no room for words beside its axis: they stand above it.
    Object.keys(figure.layout).forEach(function (key) {
      if (!/^yaxis\d+$/.test(key)) { return; }
      var axis = figure.layout[key];
      (figure.layout.annotations = figure.layout.annotations || []).push({
        text: axis.title.text, font: { size: 12 }, showarrow: false, xref: "paper", yref: "paper",
        x: 0, y: axis.domain[1], xanchor: "left", yanchor: "bottom"
      });
      axis.title.text = "";
    });
    figure.layout.separators = tongue.separators;
    figure.layout.template = LOOK;
    Plotly.newPlot(place, figure.data, figure.layout, {
      locale: tongue.code, locales: locales(),
      responsive: true, displaylogo: false, showTips: false, displayModeBar: coarse || place.clientWidth < NARROW_PX ? false : "hover",
      modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"]
    });
    place.states = figure.states || {};
    place.state = shared.own;
    drawn.push(place);
    restate(place);
  }
  function restate(place) {
    var change = place.states[now];
    if (!change || place.state === now) { return; }
    Object.keys(change).forEach(function (number) {
      var trace = {};
      Object.keys(change[number]).forEach(function (key) { trace[key] = [change[number][key]]; });
      Plotly.restyle(place, trace, [Number(number)]);
    });
    place.state = now;
  }
  function locales() {
    var own = {};
    own[tongue.code] = { dictionary: tongue.toolbar };
    return own;
  }
  function said(words, values) {
    return words.replace(/\{(\w+)\}/g, function (_, name) { return values[name]; });
  }
  function number(value, digits) { return value.toFixed(digits).replace(".", tongue.decimal); }
  function metres(value) { return number(value, 1) + "\u00a0m"; }
  function tell() {
    var state = shared.states[now];
    if (!state) { return; }
    var held = state.held_out_m;
    var words = said(tongue.shown, {
      model: now, crps: metres(state.crps_m), rmse: metres(state.rmse_m),
      held_out: held === null ? "–" : metres(held)
    });
    document.querySelectorAll("[data-switch]").forEach(function (box) {
      box.querySelector(".shown-error").textContent = words;
      box.querySelectorAll("[type=radio]").forEach(function (radio) {
        radio.checked = radio.value === now;
      });
    });
    document.documentElement.dataset.state = now;
  }
  function show(key) {
    now = key;
    drawn.forEach(restate);
    tell();
  }
  document.querySelectorAll("[data-switch]").forEach(function (box) {
    box.querySelectorAll("[type=radio]").forEach(function (radio) {
      radio.addEventListener("change", function () { show(radio.value); });
    });
  });
  tell();

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
    document.querySelectorAll("details").forEach(function (fold) {
      fold.dataset.was = fold.open ? "open" : ""; fold.open = true;
    });
    all();
    drawn.forEach(function (place) {
      var most = place.closest(".small") ? PRINT_SMALL_PX : PRINT_PX;
      // So low that two figures with their words go on a page: no page is half empty. But panels
      // above one another need room for the words on their axes.
      var panels = Object.keys(place._fullLayout).filter(function (key) { return /^yaxis\d*$/.test(key); });
      // Names beside rows would overlap.
      var most_high = place._fullLayout.yaxis.type === "category" || place._fullLayout.yaxis.scaleanchor ? SHEET_MOST_PX
        : PRINT_HIGH_PX + PRINT_PANEL_PX * (panels.length - 1);
      var high = Math.min(place._fullLayout.height, most_high);
      place.was = place._fullLayout.height;
      place.style.height = high + "px";
      var size = { height: high };
      if (place.clientWidth > most) { place.style.width = most + "px"; size.width = most; }
      Plotly.relayout(place, size);
      name_hidden(place, false);
    });
    sheets();
  });
  // Nobody taps on paper: names of what is not drawn would only take its room.
  function name_hidden(place, named) {
    if (!named) {
      place.unnamed = Object.keys(place.data).map(Number).filter(function (k) {
        return place.data[k].visible === "legendonly" && place.data[k].showlegend !== false;
      });
    }
    if (place.unnamed.length) { Plotly.restyle(place, { showlegend: named }, place.unnamed); }
  }
  // On paper the paths follow the brief, a sheet each: the panels have what its words leave of the page.
  // The first shares its sheet with what is said of all, where that leaves enough.
  var paths = document.getElementById("paths"), after = paths.nextElementSibling;
  function sheets() {
    paths.parentNode.insertBefore(paths, document.getElementById("brief").nextSibling);
    var rules = Array.prototype.filter.call(document.styleSheets[0].cssRules, function (rule) {
      return rule.media && rule.media.mediaText === "print";
    });
    function as(media, width) {
      rules.forEach(function (rule) { rule.media.mediaText = media; });
      document.body.style.width = width;
    }
    as("all", PAGE_WIDE_PX + "px");
    var top = paths.getBoundingClientRect().top;
    var sizes = Array.prototype.map.call(paths.querySelectorAll("article"), function (sheet, k) {
      var place = sheet.querySelector("[data-figure^=path-]");
      var high = place && PAGE_HIGH_PX - (sheet.offsetHeight - place.offsetHeight);
      // A map comes on the next sheet.
      sheet.querySelectorAll("figure ~ figure").forEach(function (map) { high += map.offsetHeight; });
      var under = k ? 0 : sheet.getBoundingClientRect().top - top;
      var shares = !k && high - under >= FIRST_LEAST_PX;
      sheet.classList.toggle("shares", shares);
      return place && { place: place, high: shares ? high - under : high, least: shares ? FIRST_LEAST_PX : SHEET_LEAST_PX };
    });
    as("print", "");
    sizes.forEach(function (size) {
      if (!size || size.high < size.least) { return; }
      size.place.style.height = Math.min(size.high, SHEET_MOST_PX) + "px";
      Plotly.relayout(size.place, { height: Math.min(size.high, SHEET_MOST_PX) });
    });
  }
  window.addEventListener("afterprint", function () {
    paths.parentNode.insertBefore(paths, after);
    document.querySelectorAll("details").forEach(function (fold) { fold.open = fold.dataset.was === "open"; });
    drawn.forEach(function (place) {
      if (!place.was) { return; }
      place.style.width = "";
      place.style.height = place.was + "px";
      Plotly.relayout(place, { width: null, height: place.was, autosize: true });
      name_hidden(place, true);
    });
  });
  next();
})();
