"use strict";
// The 3D view: starts vtk.js on the scene of the page, then gives it layers to switch, a cut, and places to fly to.
(() => {
  const holder = document.getElementById("view3d");
  const stage = holder.querySelector(".stage");
  const message = holder.querySelector(".message");
  const controls = document.getElementById("view-controls");
  const scene = JSON.parse(document.getElementById("scene").textContent);
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const HOME = [0.5, -0.85, 0.55];
  const LONGEST_WAIT_MS = 60000;
  let view = null;

  function start() {
    if (!document.createElement("canvas").getContext("webgl2")) {
      message.textContent = "This browser has no WebGL 2, which the 3D view needs.";
      return;
    }
    window.global = window;
    // vtk.js calls this when it is ready
    window.loadDataSet = () => {
      window.OfflineLocalView.load(stage, { base64Str: scene.archive });
      waitForLayers(performance.now());
    };
    const script = document.createElement("script");
    script.type = "module";
    script.textContent = document.getElementById("vtkjs").textContent;
    document.body.append(script);
  }

  function waitForLayers(since) {
    const renderers = window.renderWindow?.getRenderers() ?? [];
    const renderer = renderers.find((one) => one.getActors().length === scene.layers.length);
    const actors = renderer?.getActors() ?? [];
    if (actors.length && actors.every((one) => one.getMapper()?.getInputData()?.getPoints()?.getData()?.length)) {
      // the loader brings an empty one of its own, which would take the mouse
      renderers.filter((one) => one !== renderer).forEach((one) => window.renderWindow.removeRenderer(one));
      setUp(renderer, actors);
    }
    else if (performance.now() - since < LONGEST_WAIT_MS) setTimeout(waitForLayers, 50, since);
    else message.textContent = "The 3D view could not be drawn.";
  }

  function setUp(renderer, actors) {
    view = { renderer, actors, camera: renderer.getActiveCamera(), home: 1 };
    message.remove();
    addControls();
    zoomOnlyWhenChosen();
    paintBackground();
    dark.addEventListener("change", () => { paintBackground(); draw(); });
    look(HOME);
    for (const button of document.querySelectorAll("button.goto")) {
      button.hidden = false;
      button.addEventListener("click", () => flyTo(JSON.parse(button.dataset.at)));
    }
    holder.dataset.ready = "yes";
  }

  function draw() {
    view.renderer.resetCameraClippingRange();
    window.renderWindow.render();
  }

  // The page's own colours, light or dark, for the background and for lines drawn in ink.
  function paintBackground() {
    const style = getComputedStyle(holder);
    const parts = (color) => color.match(/[\d.]+/g).slice(0, 3).map((part) => Number(part) / 255);
    view.renderer.setBackground(...parts(style.backgroundColor));
    scene.layers.forEach((layer, index) => {
      if (layer.ink) view.actors[index].getProperty().setColor(...parts(style.color));
    });
  }

  function look(toward) {
    const up = Math.abs(toward[2]) > 0.99 * Math.hypot(...toward) ? [0, 1, 0] : [0, 0, 1];
    view.camera.set({ focalPoint: [0, 0, 0], position: toward, viewUp: up, parallelProjection: true });
    view.renderer.resetCamera();
    view.camera.setParallelScale(0.52);
    draw();
  }

  // at: in the coordinates of the model
  function flyTo(at) {
    const target = at.map((x, k) => (x - scene.center[k]) / scene.diagonal);
    const away = view.camera.getPosition().map((x, k) => x - view.camera.getFocalPoint()[k]);
    view.camera.set({ focalPoint: target, position: target.map((x, k) => x + away[k]) });
    view.camera.setParallelScale(0.08);
    scene.layers.forEach((layer, index) => { if (layer.title.startsWith("worst")) show(index, true); });
    setTransparent(true);
    draw();
    holder.scrollIntoView({ behavior: "smooth", block: "center" });
  }

  function show(index, shown) {
    view.actors[index].setVisibility(shown);
    controls.querySelectorAll("input[data-layer]")[index].checked = shown;
  }

  function setTransparent(on) {
    controls.querySelector("input[data-through]").checked = on;
    scene.layers.forEach((layer, index) => {
      if (/ mesh, /.test(layer.title)) view.actors[index].getProperty().setOpacity(on ? 0.2 : 1);
    });
  }

  function addControls() {
    scene.layers.forEach((layer, index) => {
      const box = checkbox(layer.title, layer.shown, (on) => { show(index, on); draw(); });
      box.dataset.layer = index;
    });
    checkbox("see through", false, (on) => { setTransparent(on); draw(); }).dataset.through = "";
    if (scene.cut) addCut();
    for (const [name, toward] of [["reset", HOME], ["x", [1, 0, 0]], ["y", [0, -1, 0]], ["z", [0, 0, 1]]]) {
      button(name === "reset" ? "reset" : `along ${name}`, () => look(toward));
    }
    button("full screen", () => (document.fullscreenElement ? document.exitFullscreen() : holder.requestFullscreen()));
    controls.hidden = false;
  }

  function checkbox(text, on, changed) {
    const label = document.createElement("label");
    const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: on });
    box.addEventListener("change", () => changed(box.checked));
    label.append(box, text);
    controls.append(label);
    return box;
  }

  function button(text, pressed) {
    const made = Object.assign(document.createElement("button"), { type: "button", textContent: text });
    made.addEventListener("click", pressed);
    controls.append(made);
  }

  // The wheel scrolls the page until the view has been clicked.
  function zoomOnlyWhenChosen() {
    let chosen = false;
    document.addEventListener("pointerdown", (event) => { chosen = holder.contains(event.target); });
    holder.addEventListener("wheel", (event) => { if (!chosen) event.stopPropagation(); }, { capture: true });
  }

  async function numbers(text, Kind) {
    const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
    const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Kind(await new Response(plain).arrayBuffer());
  }

  function addCut() {
    const label = document.createElement("label");
    const axis = document.createElement("select");
    for (const name of ["no cut", "cut x", "cut y", "cut z"]) axis.append(new Option(name));
    axis.selectedIndex = 0;
    const slider = Object.assign(document.createElement("input"), { type: "range", min: 0, max: 1, step: 0.01, value: 0.5 });
    let hexes = null;
    const update = async () => {
      hexes ??= await loadHexes();
      cutHexes(hexes, axis.selectedIndex - 1, Number(slider.value));
      draw();
    };
    axis.addEventListener("change", update);
    slider.addEventListener("input", update);
    label.append(axis, slider);
    controls.append(label);
  }

  async function loadHexes() {
    const actor = view.actors[scene.layers.findIndex((layer) => layer.title === scene.cut.layer)];
    const [corners, owners, colors] = await Promise.all([
      numbers(scene.cut.corners, Uint32Array),
      numbers(scene.cut.owners, Int32Array),
      numbers(scene.cut.colors, Uint8Array),
    ]);
    const data = actor.getMapper().getInputData();
    const points = data.getPoints().getData();
    const centers = new Float32Array(colors.length);
    for (let face = 0; face < owners.length / 2; face++) {
      for (const owner of [owners[2 * face], owners[2 * face + 1]]) {
        if (owner < 0) continue;
        for (let corner = 0; corner < 4; corner++) {
          for (let k = 0; k < 3; k++) centers[3 * owner + k] += points[3 * corners[4 * face + corner] + k] / 24;
        }
      }
    }
    return { data, corners, owners, colors, centers };
  }

  // Shows the hexes behind the plane at `share` of the way along the axis (-1: all of them).
  function cutHexes({ data, corners, owners, colors, centers }, axis, share) {
    const [low, high] = axis < 0 ? [0, 0] : data.getBounds().slice(2 * axis, 2 * axis + 2);
    const level = low + share * (high - low);
    const kept = (hex) => hex >= 0 && (axis < 0 || (axis === 1 ? centers[3 * hex + axis] >= level : centers[3 * hex + axis] <= level));
    const polygons = [];
    const paint = [];
    for (let face = 0; face < owners.length / 2; face++) {
      const [one, other] = [owners[2 * face], owners[2 * face + 1]];
      if (kept(one) === kept(other)) continue;
      const seen = kept(one) ? one : other;
      polygons.push(4, corners[4 * face], corners[4 * face + 1], corners[4 * face + 2], corners[4 * face + 3]);
      paint.push(colors[3 * seen], colors[3 * seen + 1], colors[3 * seen + 2]);
    }
    data.getPolys().setData(Uint32Array.from(polygons), 1);
    data.getCellData().getArrayByName("color").setData(Uint8Array.from(paint), 3);
    data.modified();
  }

  start();
})();
