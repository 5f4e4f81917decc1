// Draws the scene, and the teeth anew only when they or the view have changed:
// window.beveloidKeptTeeth(renderer, gears), with the gears of gears.js.
//
// Without a graphics card, the teeth take most of the time of a picture. While a value is changed they move
// less than a pixel, and only paths, points and patterns on them change. Colours and depths of the teeth
// (layer 0) are then taken from a buffer, and only the other objects (layer `gears.over`) are drawn.
"use strict";

window.beveloidKeptTeeth = function (renderer, gears) {
  const T = window.THREE,
    { scene, members, over } = gears;
  const SAMPLES = 4; // per pixel, against jagged edges, as the canvas has them
  const buffer = new T.WebGLRenderTarget(1, 1, { samples: SAMPLES, type: T.HalfFloatType });
  buffer.depthTexture = new T.DepthTexture(1, 1);

  // A rectangle over the whole canvas with the colours and depths of the buffer. The buffer has linear colours
  // that are multiplied by their opacity; the canvas needs the colours of the screen, multiplied as well.
  const material = new T.ShaderMaterial({
    uniforms: { colours: { value: buffer.texture }, depths: { value: buffer.depthTexture } },
    vertexShader: "varying vec2 at; void main() { at = uv; gl_Position = vec4(position.xy, 1.0, 1.0); }",
    fragmentShader: `
      uniform sampler2D colours, depths;
      varying vec2 at;
      void main() {
        vec4 kept = texture2D(colours, at);
        gl_FragColor = vec4(kept.rgb / max(kept.a, 1e-4), 1.0);
        #include <colorspace_fragment>
        gl_FragColor = vec4(gl_FragColor.rgb * kept.a, kept.a);
        gl_FragDepth = texture2D(depths, at).r;
      }`,
    depthFunc: T.AlwaysDepth,
    blending: T.NoBlending,
  });
  const rectangle = new T.Mesh(new T.PlaneGeometry(2, 2), material);
  rectangle.layers.set(over);
  rectangle.renderOrder = -1;
  rectangle.frustumCulled = false;
  rectangle.visible = false;
  scene.add(rectangle);
  let kept = "", // what the buffer shows
    lastView = "";

  function drawTeeth(camera) {
    buffer.setSize(renderer.domElement.width, renderer.domElement.height);
    camera.layers.set(0);
    renderer.setRenderTarget(buffer);
    renderer.clear();
    renderer.render(scene, camera);
    renderer.setRenderTarget(null);
  }

  // `look` is a number that changes with the colours of the teeth. While teeth or camera move from picture to
  // picture (`moving`), a buffer would only cost time.
  function render(camera, look, moving) {
    const { width, height } = renderer.domElement;
    scene.updateMatrixWorld();
    const view = [width, height, ...camera.matrixWorld.elements, ...camera.projectionMatrix.elements].join();
    const teeth = members.flatMap(({ spin, display }) => [display, ...spin.matrixWorld.elements]).join();
    const shows = [view, teeth, look].join();
    // What is behind a see-through gear must be drawn before it.
    const keeps = !moving && view === lastView && !members.some(({ display }) => display === "glass");
    lastView = view;
    if (keeps && shows !== kept) {
      drawTeeth(camera);
      kept = shows;
    }
    rectangle.visible = keeps;
    camera.layers.set(over);
    if (!keeps) camera.layers.enable(0);
    renderer.render(scene, camera);
  }

  function dispose() {
    buffer.depthTexture.dispose();
    buffer.dispose();
  }

  return { render, dispose };
};
