
// One page at a time: the one that the address names, or that holds the place it names. Without this all stand
// below one another.
(() => {
  "use strict";
  const views = [...document.querySelectorAll(".view")];
  const title = document.title;
  document.body.classList.add("routed");

  function show() {
    const place = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const view = place?.closest(".view") ?? views[0];
    for (const one of views) one.classList.toggle("shown", one === view);
    for (const link of document.querySelectorAll("nav a"))
      link.toggleAttribute("aria-current", views.length > 1 && link.hash === `#${view.id}`);
    const heading = view.querySelector("h2");
    document.title = view === views[0] ? title : `${heading.textContent} · ${title}`;
    for (let fold = place?.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
    if (place && place !== view) place.scrollIntoView();
    else scrollTo(0, 0);
  }

  addEventListener("hashchange", show);
  show();
})();
