"use strict";
// The values that hovering, touching or the keyboard shows.
(() => {
  const tip = document.getElementById("tip"), said = document.getElementById("said");
  if (!tip || !said) return;
  const show = (hit, x, y) => {
    tip.textContent = hit.dataset.says;
    const { width, height } = tip.getBoundingClientRect();
    tip.style.left = Math.max(4, Math.min(x + 14, innerWidth - width - 4)) + "px";
    tip.style.top = Math.max(4, y - height - 12) + "px";
    tip.style.visibility = "visible";
  };
  for (const title of document.querySelectorAll(".hit > title")) {
    title.parentNode.dataset.says = title.textContent;
    title.remove();
  }
  // The value that the keyboard is at.
  let at = null;
  const leave = () => {
    if (at) at.classList.remove("on");
    at = null;
    tip.style.visibility = "hidden";
  };
  const beside = () => {
    const { left, top, width, height } = at.getBoundingClientRect();
    show(at, left + width / 2, top + height / 2);
  };
  document.documentElement.classList.add("reads");
  for (const figure of document.querySelectorAll("svg.figure")) {
    const hits = [...figure.querySelectorAll(".hit")];
    if (!hits.length) continue;
    figure.setAttribute("tabindex", "0");
    // Lets the arrow keys through a screen reader.
    figure.setAttribute("role", "application");
    figure.setAttribute("aria-roledescription", "figure");
    figure.setAttribute("aria-label", figure.getAttribute("aria-label") + ". The arrow keys read its values.");
    figure.addEventListener("keydown", (event) => {
      const last = hits.length - 1, now = hits.indexOf(at);
      const to = {
        ArrowRight: Math.min(now + 1, last), ArrowLeft: Math.max(now - 1, 0), Home: 0, End: last,
      }[event.key];
      if (event.key === "Escape") leave();
      if (to === undefined) return;
      event.preventDefault();
      leave();
      at = hits[to];
      at.classList.add("on");
      at.scrollIntoView({ block: "nearest", inline: "nearest" });
      beside();
      said.textContent = at.dataset.says;
    });
    figure.addEventListener("blur", leave);
  }
  addEventListener("pointerover", (event) => {
    const hit = event.target.closest ? event.target.closest(".hit") : null;
    if (hit) show(hit, event.clientX, event.clientY);
    else if (at) beside();
    else tip.style.visibility = "hidden";
  });
  addEventListener("scroll", () => { at ? beside() : leave(); }, { passive: true, capture: true });
})();

// The view that turns.
(() => {
  const canvas = document.getElementById("view");
  const data = document.getElementById("scene");
  const pen = canvas && data ? canvas.getContext("2d") : null;
  if (!pen) return;
  const scene = JSON.parse(data.textContent);
  canvas.closest("figure").classList.add("turns");
  let turn = -0.98, tilt = 0.39;
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const draw = () => {
    const ratio = devicePixelRatio || 1;
    const width = canvas.clientWidth * ratio, height = canvas.clientHeight * ratio;
    if (!width || !height) return;
    canvas.width = width;
    canvas.height = height;
    const scale = 0.47 * Math.min(width, height) / scene.radius * 1.12;
    const [s, c] = [Math.sin(turn), Math.cos(turn)], [st, ct] = [Math.sin(tilt), Math.cos(tilt)];
    const place = (p) => {
      const [x, y, z] = [0, 1, 2].map((k) => p[k] - scene.centre[k]);
      const right = -s * x + c * y, towards = c * x + s * y;
      return [width / 2 + scale * right, height / 2 - scale * (ct * z - st * towards), ct * towards + st * z];
    };
    const looks = {
      box: [colour("--faint"), 1], track: [colour("--k0"), 1.8], beam: [colour("--k5"), 0.8], arrow: [colour("--k1"), 2.2],
    };
    pen.clearRect(0, 0, width, height);
    for (const line of scene.lines) {
      const [stroke, wide] = looks[line.class] || looks.box;
      pen.strokeStyle = stroke;
      pen.lineWidth = wide * ratio;
      pen.setLineDash(line.class === "beam" ? [4 * ratio, 5 * ratio] : []);
      pen.beginPath();
      line.points.forEach((p, k) => { const [x, y] = place(p); k ? pen.lineTo(x, y) : pen.moveTo(x, y); });
      pen.stroke();
    }
    pen.setLineDash([]);
    pen.font = 13 * ratio + "px system-ui, sans-serif";
    const taken = [];
    const points = scene.points.map((point) => [point, place(point.at)]).sort((a, b) => b[1][2] - a[1][2]);
    for (const [point, [x, y]] of points) {
      if (point.class !== "axis") {
        pen.fillStyle = colour(point.class === "station" ? "--ink" : "--k0");
        pen.beginPath();
        pen.arc(x, y, (point.class === "station" ? 4.5 : 3.6) * ratio, 0, 2 * Math.PI);
        pen.fill();
      }
      const wide = pen.measureText(point.name).width, high = 13 * ratio;
      const gap = 7 * ratio;
      for (const [dx, dy] of [[gap, -2 * ratio], [-gap - wide, -2 * ratio], [gap, high], [-gap - wide, high]]) {
        const area = [x + dx, y + dy - high, wide, high * 1.2];
        const covers = (o) => area[0] < o[0] + o[2] && o[0] < area[0] + area[2] && area[1] < o[1] + o[3] && o[1] < area[1] + area[3];
        if (taken.some(covers) || area[0] < 0 || area[0] + wide > width) continue;
        taken.push(area);
        pen.fillStyle = colour(point.class === "axis" ? "--k1" : "--ink");
        pen.fillText(point.name, x + dx, y + dy);
        break;
      }
    }
    canvas.dataset.turn = turn.toFixed(3);
  };
  let held = null;
  canvas.addEventListener("pointerdown", (event) => {
    held = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held) return;
    turn -= (event.clientX - held[0]) / 140;
    tilt = Math.max(-1.5, Math.min(1.5, tilt + (event.clientY - held[1]) / 140));
    held = [event.clientX, event.clientY];
    draw();
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { held = null; });
  canvas.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    if (!by) return;
    event.preventDefault();
    turn += by[0];
    tilt = Math.max(-1.5, Math.min(1.5, tilt + by[1]));
    draw();
  });
  addEventListener("resize", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();
})();
