// What all views share: requests one at a time, the newest wins; the command; keys; what is made ready.
"use strict";
const studio = (() => {
  const $ = (id) => document.getElementById(id);

  function lost(words) {
    $("lost").textContent = words;
    $("lost").hidden = !words;
  }

  // One request in flight; of those that come meanwhile only the last is sent.
  function newest(receive) {
    let busy = false, next = null;
    async function send(address) {
      if (busy) { next = address; return; }
      busy = true;
      try {
        const answer = await fetch(address, { headers: { accept: "application/json" } });
        if (answer.status === 403) lost("The studio was started again: open the address that it printed.");
        else { lost(""); receive(await answer.json(), address, next !== null); }
      } catch {
        lost("The studio does not answer. Work that runs goes on; the page asks again in two seconds.");
        next ??= address;
        await new Promise((ready) => setTimeout(ready, 2000));
      }
      busy = false;
      if (next !== null) { const address = next; next = null; send(address); }
    }
    return send;
  }

  async function post(address, body, headers = {}) {
    try {
      const answer = await fetch(address, { method: "POST", body, headers });
      const text = await answer.text();
      let found;
      try { found = JSON.parse(text); } catch { found = { refusal: text.trim() }; }
      if (!answer.ok && !found.refusal) found.refusal = `The studio answered ${answer.status}.`;
      return found;
    } catch {
      return { refusal: "The studio does not answer: is it still running in the terminal?" };
    }
  }

  function command(words) {
    if (words !== undefined) $("command").textContent = words;
  }

  async function copy() {
    const words = $("command").textContent;
    try { await navigator.clipboard.writeText(words); } catch {
      const range = document.createRange();
      range.selectNodeContents($("command"));
      getSelection().removeAllRanges();
      getSelection().addRange(range);
      return;
    }
    $("copy").textContent = "Copied";
    setTimeout(() => { $("copy").textContent = "Copy"; }, 1500);
  }
  $("copy").addEventListener("click", copy);
  $("keys-open").addEventListener("click", () => $("keys").showModal());

  function links(query) {
    for (const link of document.querySelectorAll("a[data-tab], .brand a")) link.search = query;
  }

  const keys = {
    "?": () => $("keys").showModal(), c: copy, u: () => history.back(),
    "/": () => document.querySelector("main select, main input:not([type=file])")?.focus(),
    t: () => $("tour-open").click(),
  };
  document.querySelectorAll("a[data-tab]").forEach((link, k) => { keys[String(k + 1)] = () => link.click(); });
  document.addEventListener("keydown", (event) => {
    const typing = event.target.closest?.("input:not([type=range], [type=checkbox], [type=radio]), textarea, select, dialog[open]");
    if (typing || event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });

  async function ready() {
    try {
      const words = await (await fetch("/ready")).text();
      $("warming").textContent = words;
      $("warming").hidden = !words;
      if (words) setTimeout(ready, 1000);
    } catch { setTimeout(ready, 3000); }
  }
  if (!$("warming").hidden) setTimeout(ready, 700);

  return { $, newest, post, command, links, keys, lost };
})();
