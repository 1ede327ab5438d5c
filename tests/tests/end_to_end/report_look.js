"use strict";
// Looks at the pages in all frames and writes what it finds as JSON.
addEventListener("load", () => {
  const meet = (a, b) => {
    const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
    const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
    // Boxes of text hold space above and below the letters.
    return across > 1 && down > 0.25 * Math.min(a.height, b.height);
  };
  const look = (frame) => {
    const page = frame.contentDocument, view = frame.contentWindow;
    const found = { width: view.innerWidth, title: page.title, overlaps: [], outside: [], wide: [] };
    const figures = [...page.querySelectorAll("svg.figure")];
    found.figures = figures.length;
    // Of a figure that turns, the still picture is hidden: it is looked at, too.
    const still = page.querySelector(".turns");
    if (still) still.classList.remove("turns");
    for (const figure of figures) {
      const edge = figure.getBoundingClientRect();
      const texts = [...figure.querySelectorAll("text")].map((text) => [text.textContent, text.getBoundingClientRect()]);
      texts.forEach(([name, box], k) => {
        if (box.left < edge.left - 1 || box.right > edge.right + 1 || box.top < edge.top - 1 || box.bottom > edge.bottom + 1) {
          found.outside.push(name);
        }
        for (const [other, its] of texts.slice(k + 1)) if (meet(box, its)) found.overlaps.push([name, other]);
      });
    }
    if (still) still.classList.add("turns");
    if (page.documentElement.scrollWidth > view.innerWidth) found.wide.push("page");
    for (const part of page.querySelectorAll("h1,h2,h3,p,li,dd,dt,.cards div")) {
      if (part.scrollWidth > part.clientWidth + 1 && part.clientWidth > 0) found.wide.push(part.textContent.trim().slice(0, 60));
    }
    for (const table of page.querySelectorAll("table")) {
      const room = table.parentNode.getBoundingClientRect();
      const scrolls = table.parentNode.classList.contains("scroll");
      if (!scrolls && table.getBoundingClientRect().right > room.right + 1) found.wide.push(table.textContent.trim().slice(0, 60));
    }
    const canvas = page.getElementById("view");
    if (canvas) {
      const before = canvas.dataset.turn;
      canvas.dispatchEvent(new view.KeyboardEvent("keydown", { key: "ArrowLeft", cancelable: true }));
      found.turns = canvas.dataset.turn !== before;
      const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
      found.drawn = pixels.some((value) => value !== 0);
    }
    const hit = page.querySelector("#component-EXX .hit");
    if (hit) {
      hit.dispatchEvent(new view.PointerEvent("pointerover", { bubbles: true, clientX: 50, clientY: 50 }));
      const tip = page.getElementById("tip");
      found.hovered = view.getComputedStyle(tip).visibility === "visible" ? tip.textContent : "";
      const figure = hit.closest("svg");
      const press = (key) => {
        figure.dispatchEvent(new view.KeyboardEvent("keydown", { key, cancelable: true }));
        return view.getComputedStyle(tip).visibility === "visible" ? page.getElementById("said").textContent : "";
      };
      figure.focus();
      found.focused = page.activeElement === figure;
      found.pressed = ["ArrowRight", "ArrowRight", "ArrowLeft", "End", "Escape"].map(press);
    }
    return found;
  };
  // The page on paper: with the rules for print, in columns as large as a sheet between its margins, one beside the
  // other. What is cut has a part in each of two columns.
  const onPaper = (frame) => {
    const page = frame.contentDocument, mm = 96 / 25.4;
    let rules = "", margins = [];
    for (const sheet of page.styleSheets) {
      for (const media of [...sheet.cssRules].filter((rule) => rule.media)) {
        if (media.media.mediaText.includes("screen")) media.media.mediaText = "not all";
        if (media.media.mediaText !== "print") continue;
        for (const rule of media.cssRules) {
          if (rule instanceof frame.contentWindow.CSSPageRule) margins = rule.style.margin.split(" ").map(parseFloat);
          else rules += rule.cssText.replace(/break-before: page/g, "break-before: column");
        }
      }
    }
    const [width, height] = [(210 - 2 * margins[1]) * mm, (297 - 2 * margins[0]) * mm];
    frame.style.width = width + "px";
    const style = page.createElement("style");
    style.textContent = `${rules}main{width:${width}px;height:${height}px;columns:${width}px;column-gap:40px;column-fill:auto}`;
    page.head.append(style);
    const found = { cut: [], figures: 0, sheets: Math.round((page.querySelector("main").scrollWidth + 40) / (width + 40)) };
    for (const part of page.querySelectorAll("figure,svg.figure,table:not(.long,.said),.cause,h2,h3")) {
      const boxes = [...part.getClientRects()].filter((box) => box.height > 0);
      const on = new Set(boxes.map((box) => Math.floor((box.left + 1) / (width + 40))));
      const over = boxes.some((box) => box.top < -1 || box.bottom > height + 1 || box.width > width + 1);
      if (part.matches("svg.figure") && boxes.length) found.figures += 1;
      if (on.size > 1 || over) found.cut.push(part.id || part.getAttribute("aria-label") || part.textContent.trim().slice(0, 60));
    }
    return found;
  };
  const frames = [...document.querySelectorAll("iframe")];
  const paper = frames.pop();
  document.getElementById("found").textContent = JSON.stringify([...frames.map(look), onPaper(paper)]);
});
