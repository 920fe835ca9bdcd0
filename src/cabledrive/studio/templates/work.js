// Long work: forms that start it, and one piece of it with its progress as it comes.
"use strict";
(() => {
  const { $, post } = studio;
  const state = new URLSearchParams([...new URLSearchParams(location.search)].filter(([name]) => name === "drive" || name === "set"));

  for (const form of document.querySelectorAll("form.start")) {
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      const button = form.querySelector("button"), refusal = form.querySelector(".refusal");
      button.disabled = true;
      const found = await post(`/studies/start/${form.dataset.kind}?${state}`, new URLSearchParams(new FormData(form)));
      button.disabled = false;
      if (found.number) location.href = `/studies/${found.number}?${state}`;
      refusal.textContent = found.refusal ?? "";
      refusal.hidden = !found.refusal;
    });
  }

  const job = $("job");
  if (!job) return;
  const number = job.dataset.number, lines = $("lines");
  async function refresh() {
    const found = await (await fetch(`/studies/${number}/part`)).json();
    job.innerHTML = found.part; // escaped by the server
    const running = found.status === "running";
    $("cancel").hidden = !running;
    $("resume").hidden = running;
    document.dispatchEvent(new CustomEvent("job", { detail: found.status }));
    return found;
  }
  function say(words) {
    lines.append(`${words}\n`);
    lines.scrollTop = lines.scrollHeight;
  }
  function watch() {
    const source = new EventSource(`/studies/${number}/events`);
    source.onmessage = (event) => say(JSON.parse(event.data));
    source.addEventListener("end", () => { source.close(); studio.lost(""); refresh(); });
    source.onerror = () => studio.lost("The connection is lost; the work goes on, and the page asks again.");
    source.onopen = () => studio.lost("");
  }
  refresh().then(watch);
  async function act(what) {
    const found = await post(`/studies/${number}/${what}`, "");
    $("job-refusal").textContent = found.refusal ?? "";
    $("job-refusal").hidden = !found.refusal;
    await refresh();
    if (what === "resume" && !found.refusal) { lines.textContent = ""; watch(); }
  }
  async function go(address, body, target) {
    const found = await post(address, body);
    $("job-refusal").textContent = found.refusal ?? "";
    $("job-refusal").hidden = !found.refusal;
    if (!found.refusal) location.href = target(found);
  }
  job.addEventListener("click", (event) => {
    const name = event.target.dataset?.log;
    if (name) go(`/studies/${number}/log?${new URLSearchParams({ name })}`, "", (found) => `/logs?${state}&log=${found.log}`);
    if (event.target.id === "klipper") go(`/studies/start/klipper?${state}`, new URLSearchParams({ job: number }), (found) => `/studies/${found.number}?${state}`);
  });
  $("cancel").addEventListener("click", () => { $("cancel").disabled = true; act("cancel").then(() => { $("cancel").disabled = false; }); });
  $("resume").addEventListener("click", () => act("resume"));
})();
