// A log: sent as it is, drawn by least and largest value for each pixel, zoomed by asking for a part of it.
"use strict";
(() => {
  const { $, newest, post } = studio;
  const state = new URLSearchParams([...new URLSearchParams(location.search)].filter(([name]) => name === "drive" || name === "set"));

  // ---- send a file
  function send(file) {
    const request = new XMLHttpRequest(); // it reports how far an upload is
    request.open("POST", `/logs/file?${new URLSearchParams({ name: file.name })}`);
    $("sent").hidden = false;
    $("upload-refusal").hidden = true;
    request.upload.onprogress = (event) => { $("sent").value = event.loaded / event.total; };
    const refuse = (words) => { $("upload-refusal").textContent = words; $("upload-refusal").hidden = false; $("sent").hidden = true; };
    request.onerror = () => refuse("The studio does not answer: is it still running in the terminal?");
    request.onload = () => {
      let found;
      try { found = JSON.parse(request.responseText); } catch { found = { refusal: request.responseText }; }
      if (!found.log) { refuse(found.refusal || `The studio answered ${request.status}.`); return; }
      const all = new URLSearchParams(state);
      all.set("log", found.log);
      location.search = all;
    };
    request.send(file);
  }
  const drop = $("drop");
  $("upload").addEventListener("change", () => { if ($("upload").files[0]) send($("upload").files[0]); });
  addEventListener("dragover", (event) => { event.preventDefault(); drop.classList.add("over"); });
  addEventListener("dragleave", () => drop.classList.remove("over"));
  addEventListener("drop", (event) => {
    event.preventDefault();
    drop.classList.remove("over");
    if (event.dataTransfer.files[0]) send(event.dataTransfer.files[0]);
  });

  // ---- what is identified from it
  const form = $("from-log");
  form?.addEventListener("submit", async (event) => {
    event.preventDefault();
    const fields = new URLSearchParams(new FormData(form));
    fields.set("log", new URLSearchParams(location.search).get("log"));
    const kind = event.submitter?.dataset.kind ?? "identify";
    const found = await post(`/studies/start/${kind}?${state}`, fields);
    if (found.number) location.href = `/studies/${found.number}?${state}`;
    $("from-refusal").textContent = found.refusal ?? "";
    $("from-refusal").hidden = !found.refusal;
  });

  // ---- curves
  const place = $("plots");
  if (!place) return;
  const log = place.dataset.log;
  let part = [null, null], whole = null, marks = [], charts = [], shape = "";
  const chosen = () => [...document.querySelectorAll("#columns input:checked")].map((box) => box.value);

  const ask = newest((found) => {
    if (found.refusal) { place.innerHTML = ""; const words = place.appendChild(document.createElement("p")); words.className = "problem"; words.textContent = found.refusal; return; }
    whole ??= [found.start, found.end];
    part = [found.start, found.end];
    $("extent").textContent = `${curves.number(found.start)} to ${curves.number(found.end)} ${found.time ? found.time_unit : "rows"}; ${found.rows} rows in all`;
    draw(found);
  });
  function refresh() {
    const all = new URLSearchParams(chosen().map((name) => ["column", name]));
    all.set("points", String(Math.min(Math.max(Math.round(place.clientWidth), 300), 3000)));
    if (part[0] !== null) { all.set("start", String(part[0])); all.set("end", String(part[1])); }
    if (chosen().length) ask(`/logs/${log}/curves?${all}`);
    else { place.innerHTML = ""; shape = ""; }
  }
  function draw(found) {
    const now = JSON.stringify([found.series.map((one) => one.name), place.clientWidth]);
    const data = found.series.map((one) => [found.x, one.high, one.low]);
    if (now === shape) { charts.forEach((chart, k) => chart.setData(data[k])); return; }
    shape = now;
    place.innerHTML = "";
    charts = found.series.map((one, k) => {
      const name = curves.NAMES[k % 6], unit = found.units[one.name];
      const title = place.appendChild(document.createElement("p"));
      title.className = "panel-title";
      title.textContent = unit && !one.name.includes(unit) ? `${one.name} [${unit}]` : one.name;
      const box = place.appendChild(document.createElement("div"));
      box.setAttribute("role", "img");
      box.setAttribute("aria-label", `${one.name} over ${found.time ?? "row numbers"}, least and largest value for each pixel`);
      return curves.plot(box, data[k], [{ label: "largest", colour: name, band: true, width: 1 }, { label: "least", colour: name, width: 1 }],
        { x: found.time ? `${found.time}${found.time_unit ? ` [${found.time_unit}]` : ""}` : "row", y: unit || "", height: Math.max(150, 320 - 45 * found.series.length), sync: "log", select: (from, to) => { part = [from, to]; refresh(); }, marks: () => marks.filter((mark) => one.name.includes(mark.channel) || !found.series.some((other) => other.name.includes(mark.channel))) });
    });
  }
  function move(shift, factor) {
    if (!whole) return;
    const width = (part[1] - part[0]) * factor, middle = (part[0] + part[1]) / 2 + shift * (part[1] - part[0]);
    const low = Math.max(whole[0], middle - width / 2), high = Math.min(whole[1], middle + width / 2);
    if (high > low) { part = [low, high]; refresh(); }
  }
  $("columns").addEventListener("change", refresh);
  $("whole").addEventListener("click", () => { part = whole ? [...whole] : [null, null]; refresh(); });
  $("closer").addEventListener("click", () => move(0, 0.5));
  $("farther").addEventListener("click", () => move(0, 2));
  $("left").addEventListener("click", () => move(-0.4, 1));
  $("right").addEventListener("click", () => move(0.4, 1));
  refresh();

  fetch(`/logs/${log}/check`).then((answer) => answer.json()).then((found) => {
    const list = document.createElement("ul");
    for (const words of found.said ?? [found.refusal]) list.appendChild(document.createElement("li")).textContent = words;
    if (found.marks?.length) list.appendChild(document.createElement("li")).textContent = `Marked red: ${found.marks.length} stretches at the end of a channel's range.`;
    const note = document.createElement("div");
    note.className = found.refusal ? "note warning" : "note";
    note.append(list);
    $("check").replaceChildren(note);
    marks = found.marks ?? [];
    for (const chart of charts) chart.redraw();
  }).catch(() => { $("check").textContent = "The studio does not answer."; });
})();
