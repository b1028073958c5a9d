// The wall in three dimensions: rotate it, choose a field, play the beat. Data: the element's JSON, see scene.rs.
(async () => {
  'use strict';
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;

  // The library is part of the page, compressed by gzip.
  const packed = new Blob([bytes(document.getElementById('library').textContent)]).stream();
  const library = await new Response(packed.pipeThrough(new DecompressionStream('gzip'))).text();
  const {
    AmbientLight, BufferAttribute, BufferGeometry, DirectionalLight, DoubleSide, Mesh, MeshLambertMaterial,
    OrbitControls, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
  } = new Function(`${library}; return THREE;`)();

  function start(element) {
    const data = JSON.parse(element.querySelector('script').textContent);
    const canvas = element.querySelector('canvas');
    const field = element.querySelector('select');
    const time = element.querySelector('input');
    const play = element.querySelector('button');
    const label = element.querySelector('output');
    const [low, high] = element.querySelectorAll('.bar span');
    let renderer;
    try {
      // Kept, so that the view is there when the page is printed.
      renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    } catch (error) {
      canvas.replaceWith('This browser shows no three-dimensional graphics (WebGL).');
      return;
    }
    renderer.setClearColor(0xffffff);
    const points = data.points;
    const positions = new Int16Array(bytes(data.positions)); // frame by frame, in units of data.unit
    const values = data.fields.map((f) => new Uint16Array(bytes(f.values)));
    data.fields.forEach((f, i) => field.add(new Option(f.name, String(i))));

    const geometry = new BufferGeometry();
    geometry.setIndex(new BufferAttribute(new Uint32Array(bytes(data.triangles)), 1));
    const at = new BufferAttribute(new Float32Array(3 * points), 3);
    const colour = new BufferAttribute(new Float32Array(3 * points), 3);
    geometry.setAttribute('position', at);
    geometry.setAttribute('color', colour);
    const scene = new Scene();
    scene.add(new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true, side: DoubleSide })));
    scene.add(new AmbientLight(0xffffff, 2.2));
    const lamp = new DirectionalLight(0xffffff, 1.4);
    scene.add(lamp);

    const linear = (c) => ((c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
    // 256 times red, green, blue; kinds have colours of their own, and no scale.
    const palettes = data.fields.map((f) => Float32Array.from(new Uint8Array(bytes(f.colours ?? data.colours)), linear));
    const bar = element.querySelector('.bar');

    // A frame between two stored ones is a mixture of both.
    function show(t) {
      const last = data.times.length - 1;
      const before = Math.min(Math.floor(t), last);
      const after = Math.min(before + 1, last);
      const share = t - before;
      const chosen = data.fields[field.value];
      const shown = values[field.value];
      const palette = palettes[field.value];
      const frames = shown.length / points;
      for (let i = 0; i < 3 * points; i++) {
        const a = positions[3 * points * before + i];
        const b = positions[3 * points * after + i];
        at.array[i] = ((1 - share) * a + share * b) * data.unit;
      }
      for (let p = 0; p < points; p++) {
        const a = shown[frames === 1 ? p : points * before + p];
        const b = shown[frames === 1 ? p : points * after + p];
        const step = 3 * Math.round(((1 - share) * a + share * b) * 255 / 65535);
        colour.array.set(palette.subarray(step, step + 3), 3 * p);
      }
      at.needsUpdate = colour.needsUpdate = true;
      geometry.computeVertexNormals();
      const seconds = (1 - share) * data.times[before] + share * data.times[after];
      label.textContent = data.still ? '' : `t = ${seconds.toFixed(3)} s`;
      bar.style.visibility = chosen.colours ? 'hidden' : 'visible';
      low.textContent = chosen.low;
      high.textContent = `${chosen.high} ${chosen.unit}`;
      draw();
    }

    const camera = new PerspectiveCamera(28, 1, 0.001, 10);
    const middle = new Vector3(0, 0, 0); // of the box around the vessel, which lies along x
    const controls = new OrbitControls(camera, canvas);
    controls.target.copy(middle);
    controls.enablePan = false;
    controls.addEventListener('change', draw);

    function draw() {
      lamp.position.copy(camera.position);
      renderer.render(scene, camera);
    }

    // Until it is moved, the view shows all of the wall, whatever the shape of the window.
    let moved = false;
    controls.addEventListener('start', () => { moved = true; });

    function resize() {
      const { clientWidth: width, clientHeight: height } = canvas;
      renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
      renderer.setSize(width, height, false);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      if (!moved) {
        const distance = data.size / (2 * Math.tan(14 * Math.PI / 180)) / Math.min(camera.aspect, 2.2) * 1.3;
        camera.position.copy(middle).add(new Vector3(-0.35, 0.45, 1).setLength(distance));
        controls.update();
      }
      draw();
      requestAnimationFrame(draw);
    }

    let playing = false;
    let before = 0;
    function tick(now) {
      if (!playing) return;
      const last = data.times.length - 1;
      const period = 1000 * (data.times[last] - data.times[0]);
      time.value = String((Number(time.value) + (now - before) / Math.max(period, 1000) * last) % last);
      before = now;
      show(Number(time.value));
      requestAnimationFrame(tick);
    }
    play.addEventListener('click', () => {
      playing = !playing;
      play.textContent = playing ? 'Stop' : 'Play the beat';
      before = performance.now();
      if (playing) requestAnimationFrame(tick);
    });
    const single = data.times.length < 2;
    play.hidden = time.hidden = single;
    time.max = String(data.times.length - 1);
    time.value = String(data.frame);
    time.addEventListener('input', () => show(Number(time.value)));
    field.addEventListener('change', () => show(Number(time.value)));
    new ResizeObserver(resize).observe(canvas);
    show(data.frame);
    resize();
  }

  document.querySelectorAll('.viewer').forEach(start);
})();
