// What a reader can ask of a figure: the values at a place, and a closer look, by pointer, finger or keys.
// Without this the page says the same.
(() => {
  "use strict";
  const reading = document.createElement("output");
  reading.className = "reading";
  reading.hidden = true;
  reading.setAttribute("aria-hidden", "true");
  const large = document.createElement("dialog");
  large.className = "large";
  large.setAttribute("aria-label", "Figure, enlarged");
  const tools = document.createElement("div");
  tools.className = "tools";
  const said = document.createElement("output"); // a live region: keys read values into it
  const hint = document.createElement("span");
  hint.className = "hint";
  hint.textContent = "Keys: + − 0 zoom, arrows move; with Shift, arrows read values, in the next plot with Page Down.";
  large.append(tools);
  document.body.append(reading, large);

  const inPicture = (svg, event) =>
    new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());

  function valueAt(place, [first, last, low, high, logarithmic]) {
    const share = (place - first) / (last - first);
    return logarithmic ? low * (high / low) ** share : low + share * (high - low);
  }

  function readingAt(panels, at) {
    const between = (value, [first, last]) => (value - first) * (value - last) <= 0;
    const panel = panels.find((one) => between(at.x, one.x) && between(at.y, one.y));
    if (!panel) return "";
    const alike = (axis) => (one) => one[axis][5] && String(one[axis].slice(0, 5)) === String(panel[axis].slice(0, 5));
    const label = (axis) => panel[axis][5] || panels.find(alike(axis))?.[axis][5] || axis;
    const words = [["x", at.x], ["y", at.y]]
      .filter(([axis]) => panel[axis].length > 2)
      .map(([axis, place]) => `${label(axis)} ${String(Number(valueAt(place, panel[axis]).toPrecision(4))).replaceAll("-", "−")}`);
    return words.join(", ");
  }

  for (const svg of document.querySelectorAll("svg[data-axes]")) {
    const panels = JSON.parse(svg.dataset.axes);
    svg.addEventListener("pointermove", (event) => {
      reading.value = readingAt(panels, inPicture(svg, event));
      reading.hidden = !reading.value;
      const right = Math.min(event.clientX + 14, window.innerWidth - reading.offsetWidth - 8);
      reading.style.transform = `translate(${Math.max(right, 4)}px, ${Math.max(event.clientY - 38, 4)}px)`;
      (large.open ? large : document.body).append(reading);
    });
    svg.addEventListener("pointerleave", () => { reading.hidden = true; });
  }

  let shown = null; // {svg, home, whole, opener, panels, mark: {panel, x, y, lines}}
  const box = () => shown.svg.viewBox.baseVal;
  const showBox = (x, y, width, height) => shown.svg.setAttribute("viewBox", `${x} ${y} ${width} ${height}`);

  function zoom(factor, x, y) {
    const now = box();
    const least = Math.min(Math.max(factor, shown.whole[2] / 40 / now.width), shown.whole[2] / now.width);
    showBox(x - (x - now.x) * least, y - (y - now.y) * least, now.width * least, now.height * least);
  }

  function move(x, y) {
    const now = box();
    showBox(now.x + x * now.width, now.y + y * now.height, now.width, now.height);
  }

  function readAt(x, y, panelStep = 0) {
    const mark = shown.mark ??= { panel: 0, x: 0.5, y: 0.5, lines: null };
    mark.panel = (mark.panel + panelStep + shown.panels.length) % shown.panels.length;
    mark.x = Math.min(1, Math.max(0, mark.x + x));
    mark.y = Math.min(1, Math.max(0, mark.y + y));
    const panel = shown.panels[mark.panel];
    const [left, right] = panel.x, [foot, head] = panel.y;
    const at = { x: left + mark.x * (right - left), y: foot + mark.y * (head - foot) };
    mark.lines ??= shown.svg.appendChild(document.createElementNS(shown.svg.namespaceURI, "path"));
    mark.lines.setAttribute("class", "mark");
    mark.lines.setAttribute("d", `M${left} ${at.y}H${right}M${at.x} ${foot}V${head}`);
    said.value = readingAt(shown.panels, at) || "no numbers on these axes";
  }

  const zoomMiddle = (factor) => zoom(factor, box().x + box().width / 2, box().y + box().height / 2);
  const closer = () => zoomMiddle(1 / 1.4), further = () => zoomMiddle(1.4);
  const doings = [["Close", "Close", () => large.close()], ["+", "Zoom in", closer], ["−", "Zoom out", further],
    ["All", "Show all", () => showBox(...shown.whole)]];
  for (const [sign, name, doing] of doings) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = sign;
    button.setAttribute("aria-label", name);
    button.addEventListener("click", doing);
    tools.append(button);
  }
  tools.append(said, hint);

  large.addEventListener("wheel", (event) => {
    event.preventDefault();
    const at = inPicture(shown.svg, event);
    zoom(event.deltaY > 0 ? 1.2 : 1 / 1.2, at.x, at.y);
  }, { passive: false });
  large.addEventListener("pointermove", (event) => {
    if (event.buttons === 1 && !tools.contains(event.target)) move(-event.movementX / large.clientWidth, -event.movementY / large.clientHeight);
  });
  large.addEventListener("keydown", (event) => {
    const keys = event.shiftKey && event.key.startsWith("Arrow") ? {
      ArrowLeft: () => readAt(-0.02, 0), ArrowRight: () => readAt(0.02, 0),
      ArrowUp: () => readAt(0, 0.02), ArrowDown: () => readAt(0, -0.02),
    } : {
      "+": closer, "-": further, "0": () => showBox(...shown.whole),
      PageDown: () => readAt(0, 0, 1), PageUp: () => readAt(0, 0, -1),
      ArrowLeft: () => move(-0.1, 0), ArrowRight: () => move(0.1, 0), ArrowUp: () => move(0, -0.1), ArrowDown: () => move(0, 0.1),
    };
    if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
  });
  large.addEventListener("close", () => {
    showBox(...shown.whole);
    shown.mark?.lines.remove();
    said.value = "";
    shown.home.append(shown.svg);
    shown.opener.focus();
    document.body.append(reading);
    reading.hidden = true;
    shown = null;
  });

  for (const figure of document.querySelectorAll("figure")) {
    if (!figure.querySelector(".drawing svg[data-axes]")) continue;
    const button = document.createElement("button");
    button.className = "enlarge";
    button.type = "button";
    button.textContent = "Enlarge";
    button.setAttribute("aria-label", `Enlarge ${figure.querySelector(".label")?.textContent.replace(".", "") ?? "figure"}`);
    button.addEventListener("click", () => {
      const home = [...figure.querySelectorAll(".drawing")].find((one) => one.offsetParent !== null);
      const svg = home.querySelector("svg");
      const { x, y, width, height } = svg.viewBox.baseVal;
      shown = { svg, home, whole: [x, y, width, height], opener: button, panels: JSON.parse(svg.dataset.axes) };
      large.append(svg);
      large.showModal();
    });
    figure.querySelector("figcaption").append(" ", button);
  }
})();
