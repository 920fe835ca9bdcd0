// Five steps for the first visit.
"use strict";
(() => {
  const { $ } = studio;
  const STEPS = [
    ["machine", "#drive", "Open a machine", "Choose a packaged drive, a drive file of yours, or an empty machine to fill in. A file can also be dropped onto the page."],
    ["machine", "#quantities", "Change a quantity", "Type a value with its unit or move the slider: drawing, frequencies and text follow. What cannot be is refused beside its field. Undo is the browser's Back, and the address keeps every state."],
    ["machine", "#result", "See its modes", "Spans are coloured by tension. Choose a row of the table or a rung of the ladder to see that mode move, with the motor free or held."],
    ["resonance", "#main", "Resonance, logs, controllers", "The other views show the map of the internal resonance with your machine's own point, your measured logs over the model, and control laws side by side."],
    ["studies", "#main", "Studies run beside the page", "Studies, comparisons, sweeps and exports are the package's own commands: they run on while you look elsewhere, can be cancelled and resumed, and each shows the line that does the same in a terminal."],
  ];
  const view = document.body.dataset.view;
  let step = -1, pointed = null;
  const store = { get: () => { try { return localStorage.getItem("cabledrive-tour"); } catch { return "done"; } }, set: (value) => { try { localStorage.setItem("cabledrive-tour", value); } catch { /* no memory: no tour of its own accord */ } } };

  function show(next) {
    pointed?.classList.remove("pointed");
    step = next;
    const [where, what, title, words] = STEPS[step];
    if (where !== view) {
      store.set(String(step));
      const link = [...document.querySelectorAll("a[data-tab]")].find((one) => one.pathname === `/${where}`);
      link.click();
      return;
    }
    store.set("done");
    $("tour-step").textContent = `Step ${step + 1} of ${STEPS.length}`;
    $("tour-title").textContent = title;
    $("tour-words").textContent = words;
    $("tour-back").disabled = step === 0;
    $("tour-next").textContent = step === STEPS.length - 1 ? "Done" : "Next";
    pointed = document.querySelector(what);
    pointed?.classList.add("pointed");
    if (!$("tour").open) $("tour").showModal();
    $("tour-next").focus();
  }
  $("tour-next").addEventListener("click", () => { if (step === STEPS.length - 1) $("tour").close(); else show(step + 1); });
  $("tour-back").addEventListener("click", () => show(step - 1));
  $("tour-end").addEventListener("click", () => $("tour").close());
  $("tour").addEventListener("close", () => { pointed?.classList.remove("pointed"); store.set("done"); });
  $("tour-open").addEventListener("click", () => show(0));

  const kept = store.get();
  if (kept === null && view === "machine") show(0);
  else if (/^[0-4]$/.test(kept ?? "")) show(Number(kept));
})();
