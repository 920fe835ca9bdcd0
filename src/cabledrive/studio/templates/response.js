// A measured response over the computed one: magnitude, phase, coherence.
"use strict";
(() => {
  const { $ } = studio;
  const place = $("response"), choice = $("output");
  const state = new URLSearchParams([...new URLSearchParams(location.search)].filter(([name]) => name === "drive" || name === "set"));

  async function draw() {
    const all = new URLSearchParams(state);
    if (choice.value) all.set("output", choice.value);
    const answer = await fetch(`/studies/${$("job").dataset.number}/response?${all}`);
    if (!answer.ok) { place.hidden = true; return; }
    const found = await answer.json();
    place.hidden = false;
    if (!choice.options.length) choice.append(...found.outputs.map((one) => new Option(one)));
    choice.value = found.output;
    $("response-words").textContent = found.words;
    const beside = found.computed.length > 0;
    const pair = (measured, computed) => [found.frequency_hz, measured, ...(beside ? [computed] : [])];
    const lines = [{ label: "measured", colour: "blue" }, ...(beside ? [{ label: "computed", colour: "orange", dash: [6, 4], width: 1.8 }] : [])];
    const panels = [
      ["magnitude", pair(found.magnitude, found.computed), lines, { y: "magnitude, SI", log: true }],
      ["phase", pair(found.phase_deg, found.computed_phase), lines, { y: "phase [deg]" }],
      ["coherence", [found.frequency_hz, found.coherence], lines.slice(0, 1), { y: "coherence" }],
    ];
    for (const [name, data, series, options] of panels) {
      $(name).replaceChildren();
      curves.plot($(name), data, series, { x: "frequency [Hz]", height: 200, ...options });
    }
  }
  choice.addEventListener("change", draw);
  document.addEventListener("job", (event) => { if (event.detail === "done") draw(); });
})();
