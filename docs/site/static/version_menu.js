// A menu of the versions beside this one, once there are several; versions.js in the folder above names them.
const site = new URL(document.documentElement.dataset.content_root + "..", location.href);
const here = new URL(document.documentElement.dataset.content_root, location.href).pathname;

function show() {
  if (window.versions.length < 2) return;
  const menu = document.createElement("select");
  menu.className = "version-menu";
  menu.ariaLabel = "version";
  for (const version of window.versions) {
    const chosen = here.endsWith(`/${version}/`);
    menu.add(new Option(version, version, chosen, chosen));
  }
  menu.onchange = async () => {
    const front = new URL(`${menu.value}/index.html`, site);
    const same = new URL(`${menu.value}/${location.pathname.slice(here.length)}`, site);
    const found = await fetch(same, { method: "HEAD" }).catch(() => ({ ok: false })); // from a disk none is
    location.href = found.ok ? same : front;
  };
  document.querySelector(".sidebar-brand").after(menu);
}

const list = document.createElement("script");
list.src = new URL("versions.js", site);
list.onload = show;
document.head.append(list);
