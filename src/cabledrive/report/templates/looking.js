// What a pointer can ask of a figure: the values under it, and a closer look. Without this the page says the same.
(() => {
  "use strict";
  const reading = document.createElement("output");
  reading.className = "reading";
  reading.hidden = true;
  reading.setAttribute("aria-hidden", "true");
  const large = document.createElement("dialog");
  large.className = "large";
  large.setAttribute("aria-label", "Figure, enlarged: plus and minus zoom, arrows move, 0 shows all, Escape closes");
  document.body.append(reading, large);

  const inPicture = (svg, event) =>
    new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());

  function valueAt(place, [first, last, low, high, logarithmic]) {
    const share = (place - first) / (last - first);
    return logarithmic ? low * (high / low) ** share : low + share * (high - low);
  }

  function told(svg, panels, event) {
    const at = inPicture(svg, event);
    const between = (value, [first, last]) => (value - first) * (value - last) <= 0;
    const panel = panels.find((one) => between(at.x, one.x) && between(at.y, one.y));
    if (!panel) return "";
    const alike = (axis) => (one) => one[axis][5] && String(one[axis].slice(0, 5)) === String(panel[axis].slice(0, 5));
    const label = (axis) => panel[axis][5] || panels.find(alike(axis))?.[axis][5] || axis;
    const words = [["x", at.x], ["y", at.y]]
      .filter(([axis]) => panel[axis].length > 2)
      .map(([axis, place]) => `${label(axis)} ${Number(valueAt(place, panel[axis]).toPrecision(4))}`);
    return words.join(", ");
  }

  for (const svg of document.querySelectorAll("svg[data-axes]")) {
    const panels = JSON.parse(svg.dataset.axes);
    svg.addEventListener("pointermove", (event) => {
      reading.value = told(svg, panels, event);
      reading.hidden = !reading.value;
      const right = Math.min(event.clientX + 14, window.innerWidth - reading.offsetWidth - 8);
      reading.style.transform = `translate(${Math.max(right, 4)}px, ${Math.max(event.clientY - 38, 4)}px)`;
      (large.open ? large : document.body).append(reading);
    });
    svg.addEventListener("pointerleave", () => { reading.hidden = true; });
  }

  let shown = null; // {svg, home, whole}
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

  large.addEventListener("wheel", (event) => {
    event.preventDefault();
    const at = inPicture(shown.svg, event);
    zoom(event.deltaY > 0 ? 1.2 : 1 / 1.2, at.x, at.y);
  }, { passive: false });
  large.addEventListener("pointermove", (event) => {
    if (event.buttons === 1) move(-event.movementX / large.clientWidth, -event.movementY / large.clientHeight);
  });
  large.addEventListener("keydown", (event) => {
    const now = box();
    const middle = [now.x + now.width / 2, now.y + now.height / 2];
    const keys = {
      "+": () => zoom(1 / 1.4, ...middle), "-": () => zoom(1.4, ...middle), "0": () => showBox(...shown.whole),
      ArrowLeft: () => move(-0.1, 0), ArrowRight: () => move(0.1, 0), ArrowUp: () => move(0, -0.1), ArrowDown: () => move(0, 0.1),
    };
    if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
  });
  large.addEventListener("close", () => {
    showBox(...shown.whole);
    shown.home.append(shown.svg);
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
    button.addEventListener("click", () => {
      const home = [...figure.querySelectorAll(".drawing")].find((one) => one.offsetParent !== null);
      const svg = home.querySelector("svg");
      const { x, y, width, height } = svg.viewBox.baseVal;
      shown = { svg, home, whole: [x, y, width, height] };
      large.append(svg);
      large.showModal();
    });
    figure.querySelector("figcaption").append(" ", button);
  }
})();
