// The map in its frame, and a motion assessed by the command.
"use strict";
(() => {
  const { $, post } = studio;
  const asked = $("asked"), map = $("map");
  const state = new URLSearchParams([...new URLSearchParams(location.search)].filter(([name]) => name === "drive" || name === "set"));

  function query() {
    const all = new URLSearchParams(state);
    for (const [name, value] of new FormData(asked)) if (value) all.set(name, value);
    return all;
  }
  asked.addEventListener("submit", (event) => { event.preventDefault(); location.search = query(); });
  $("assess").addEventListener("click", async () => {
    const found = await post(`/studies/start/map?${state}`, new URLSearchParams(new FormData(asked)));
    if (found.number) location.href = `/studies/${found.number}?${state}`;
    $("asked-refusal").textContent = found.refusal ?? "";
    $("asked-refusal").hidden = !found.refusal;
  });
  addEventListener("message", (event) => {
    if (event.source === map?.contentWindow && event.data > 0 && event.data < 5000) map.height = Math.ceil(event.data);
  });
  if (map) {
    const all = new URLSearchParams(map.dataset.source.split("?")[1]);
    for (const [name, value] of query()) if (name === "torque" || name === "motion") all.set(name, value);
    const address = `/resonance/map?${all}`;
    fetch(address).then(async (answer) => {
      if (answer.ok) { map.src = address; $("map-wait").hidden = true; return; }
      const words = await answer.text();
      try { $("map-wait").textContent = JSON.parse(words).refusal; } catch { $("map-wait").textContent = words; }
      $("map-wait").className = "problem";
      map.hidden = true;
    }).catch(() => { $("map-wait").textContent = "The studio does not answer."; });
  }
})();
