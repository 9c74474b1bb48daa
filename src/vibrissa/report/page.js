"use strict";

// Plays a scan: the rod, drawn from its shape, and the clamp's readings with a moving mark.
(() => {
  const UNIT = 1e-4; // of the whole numbers that shapes are made of
  const SCALE = 1000; // of the drawing: units to a length L
  const HALF_BASE = 14;
  const READINGS = ["fx", "fy", "m"];
  const runs = JSON.parse(document.getElementById("scans").textContent);
  const at = (id) => document.getElementById(id);
  const [stage, play, slider, choice] = ["stage", "play", "step", "scan"].map(at);

  let run, frame, started, plots;

  function add(parent, name, attributes) {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    return parent.appendChild(node);
  }

  const spell = (value, digits) =>
    value === null ? "–" : value.toFixed(digits).replace("-", "−");

  // Digits with which two ends of a scale are told apart.
  const digits = (span) => Math.min(5, Math.max(0, 2 - Math.floor(Math.log10(span || 1))));

  function drawStage() {
    const eta = SCALE * run.eta;
    let [left, right] = [Infinity, -Infinity];
    run.shape.forEach((shape, i) => {
      const points = run.shapes[shape];
      for (let k = 0; k < points.length; k += 2) {
        const x = SCALE * (run.clamp[i] + UNIT * points[k]);
        left = Math.min(left, x);
        right = Math.max(right, x);
      }
    });
    [left, right] = [left - 80, right + 80];
    // y goes down in a drawing: the surface is above.
    stage.replaceChildren();
    stage.setAttribute("viewBox", `${left} ${-eta - 70} ${right - left} ${eta + 150}`);
    // Lines go on to the edges of a window that is wider than what moves.
    const [from, to] = [left - 3000, right + 3000];
    add(stage, "path", { class: "rail", d: `M${from} 40H${to}` });
    let hatch = "";
    for (let x = from; x < to; x += 24) hatch += `M${x} ${-eta}l26 -26`;
    add(stage, "path", { class: "hatch", d: hatch });
    add(stage, "path", { class: "surface", d: `M${from} ${-eta}H${to}` });
    return {
      rod: add(stage, "path", { class: "rod" }),
      clamp: add(stage, "path", { class: "clamp" }),
      contact: add(stage, "circle", { class: "contact", r: 11 }),
    };
  }

  // A plot's curve, and where its mark belongs in each frame, in per cent of the plot.
  function drawSignal(name) {
    const figure = at(`signal-${name}`);
    const values = run[name].map((value) => (value === null ? NaN : value));
    const known = values.filter((value) => !Number.isNaN(value));
    const [low, high] = [Math.min(...known), Math.max(...known)];
    const far = run.clamp[run.clamp.length - 1] || 1;
    const across = (i) => (100 * run.clamp[i]) / far;
    const down = (value) => (100 * (high - value)) / (high - low || 1);
    const svg = figure.querySelector("svg");
    svg.replaceChildren();
    let [path, pen] = ["", "M"];
    values.forEach((value, i) => {
      if (Number.isNaN(value)) pen = "M";
      else {
        path += `${pen}${(10 * across(i)).toFixed(1)} ${down(value).toFixed(2)}`;
        pen = "L";
      }
    });
    if (low < 0 && high > 0) add(svg, "path", { class: "zero", d: `M0 ${down(0)}H1000` });
    add(svg, "path", { class: "curve", d: path });
    const mark = add(svg, "path", { class: "mark" });
    const [top, bottom] = figure.querySelectorAll(".ends span");
    top.textContent = spell(high, digits(high - low));
    bottom.textContent = spell(low, digits(high - low));
    const [dot, output] = [figure.querySelector(".dot"), figure.querySelector("output")];
    const padding = parseFloat(getComputedStyle(figure.querySelector(".plot")).paddingTop);
    return (i) => {
      const known = !Number.isNaN(values[i]);
      mark.setAttribute("d", `M${10 * across(i)} 0V100`);
      dot.hidden = !known;
      dot.style.left = `${across(i)}%`;
      if (known) {
        const part = down(values[i]) / 100;
        dot.style.top = `calc(${padding}px + ${part} * (100% - ${2 * padding}px))`;
      }
      output.textContent = spell(run[name][i], 4);
    };
  }

  // The rod's outline: its points, moved to both sides by half its diameter.
  function outline(i) {
    const points = run.shapes[run.shape[i]];
    const [there, back] = [[], []];
    const count = points.length / 2;
    const x = (k) => SCALE * (run.clamp[i] + UNIT * points[2 * k]);
    const y = (k) => -SCALE * UNIT * points[2 * k + 1];
    for (let k = 0; k < count; k += 1) {
      const [before, after] = [Math.max(0, k - 1), Math.min(count - 1, k + 1)];
      const [dx, dy] = [x(after) - x(before), y(after) - y(before)];
      const half = (HALF_BASE * (1 - (1 - 1 / run.theta) * run.s[k])) / (Math.hypot(dx, dy) || 1);
      there.push(`${(x(k) - half * dy).toFixed(1)} ${(y(k) + half * dx).toFixed(1)}`);
      back.unshift(`${(x(k) + half * dy).toFixed(1)} ${(y(k) - half * dx).toFixed(1)}`);
    }
    return `M${there.concat(back).join("L")}Z`;
  }

  let drawing;

  function show(i) {
    frame = i;
    const [clamp, slipped] = [SCALE * run.clamp[i], Boolean(run.slip[i])];
    drawing.rod.setAttribute("d", outline(i));
    drawing.clamp.setAttribute("d", `M${clamp - 34} 0h68v40h-68z`);
    drawing.contact.setAttribute("cx", SCALE * run.contact[i]);
    drawing.contact.setAttribute("cy", -SCALE * run.eta);
    drawing.contact.classList.toggle("slip", slipped);
    plots.forEach((mark) => mark(i));
    const where = `Clamp at ${spell(run.clamp[i], 4)} L, cycle ${run.cycle[i]}:`;
    const turn = run.turn[i];
    const sticks = turn ? `swings aside, turned by ${turn}°` : "sticks";
    const phase = slipped ? "has just slipped" : sticks;
    at("where").textContent = where;
    at("phase").textContent = phase;
    at("phase").classList.toggle("slip", slipped);
    slider.value = i;
    slider.setAttribute("aria-valuetext", `${where} ${phase}`);
  }

  function stop() {
    started = undefined;
    play.textContent = "Play";
  }

  function start() {
    const last = run.shape.length - 1;
    if (frame === last) show(0);
    const duration = 1000 * Math.min(24, Math.max(5, last / 25));
    const from = frame;
    const mine = (started = {});
    let begin;
    play.textContent = "Pause";
    const tick = (now) => {
      if (started !== mine) return;
      begin = begin ?? now;
      const next = Math.min(last, from + Math.floor((last * (now - begin)) / duration));
      if (next !== frame) show(next);
      if (next === last) stop();
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  function choose(number) {
    stop();
    run = runs[number];
    slider.max = run.shape.length - 1;
    at("far").textContent = spell(run.clamp[run.clamp.length - 1], 3);
    drawing = drawStage();
    plots = READINGS.map(drawSignal);
    show(0);
  }

  play.addEventListener("click", () => (started ? stop() : start()));
  slider.addEventListener("input", () => {
    stop();
    show(Number(slider.value));
  });
  choice?.addEventListener("change", () => choose(Number(choice.value)));
  at("player").hidden = false;
  choose(Number(choice?.value ?? 0));
})();
