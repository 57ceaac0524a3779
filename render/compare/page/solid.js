// A film in three dimensions: the run's glTF, as `tumble export --gltf` writes it, at the instant that the film shows.
// Dragging turns the view, dragging with shift moves it, the wheel comes nearer.
const solid = (() => {
    const waiting = {};   // path -> what takes the file

    // A file of the gallery's calls this: pages opened from a disk may not fetch, but may load scripts.
    const arrived = (path, base64) =>
        waiting[path](Uint8Array.from(atob(base64), letter => letter.charCodeAt(0)).buffer);

    const load = path => new Promise((take, fail) => {
        waiting[path] = take;
        const script = document.createElement('script');
        script.src = path.split('/').map(encodeURIComponent).join('/') + '.js';
        script.onerror = () => fail(new Error('cannot read ' + script.src));
        document.head.append(script);
    });

    // --- glTF ---------------------------------------------------------------------------------------------------
    const parse = glb => {
        const view = new DataView(glb);
        const json_bytes = view.getUint32(12, true);
        const json = JSON.parse(new TextDecoder().decode(new Uint8Array(glb, 20, json_bytes)));
        const binary = 20 + json_bytes + 8;
        const widths = {SCALAR: 1, VEC3: 3, VEC4: 4};
        const values = index => {
            const accessor = json.accessors[index];
            const part = json.bufferViews[accessor.bufferView];
            const Numbers = accessor.componentType === 5125 ? Uint32Array : Float32Array;
            return new Numbers(glb, binary + (part.byteOffset || 0), accessor.count * widths[accessor.type]);
        };
        const channels = (json.animations || []).flatMap(animation => animation.channels.map(channel => ({
            node: channel.target.node,
            path: channel.target.path,
            times: values(animation.samplers[channel.sampler].input),
            values: values(animation.samplers[channel.sampler].output),
        })));
        return {json, values, channels};
    };

    const value_at = (channel, time) => {
        const {times, values} = channel;
        const width = values.length / times.length;
        let low = 0, high = times.length - 1;
        while (high - low > 1) {
            const middle = (low + high) >> 1;
            times[middle] <= time ? low = middle : high = middle;
        }
        const share = Math.min(Math.max((time - times[low]) / (times[high] - times[low] || 1), 0), 1);
        const a = values.subarray(low * width, low * width + width), b = values.subarray(high * width, high * width + width);
        let from = 1 - share, to = share;
        if (channel.path === 'rotation') {   // along the great circle
            const cosine = Math.min(Math.abs(a.reduce((sum, x, i) => sum + x * b[i], 0)), 1), angle = Math.acos(cosine);
            if (angle > 1e-4)
                [from, to] = [Math.sin(from * angle) / Math.sin(angle), Math.sin(to * angle) / Math.sin(angle)];
        }
        return Array.from(a, (x, i) => from * x + to * b[i]);
    };

    // --- matrices, columns one after the other ---------------------------------------------------------------------
    const product = (a, b) => Float32Array.from({length: 16}, (_, i) =>
        a[i & 3] * b[i & 12] + a[(i & 3) + 4] * b[(i & 12) + 1] + a[(i & 3) + 8] * b[(i & 12) + 2] + a[(i & 3) + 12] * b[(i & 12) + 3]);
    const placed = ([x, y, z], [i, j, k, w], [a, b, c]) => new Float32Array([
        a * (1 - 2 * (j * j + k * k)), a * 2 * (i * j + k * w), a * 2 * (i * k - j * w), 0,
        b * 2 * (i * j - k * w), b * (1 - 2 * (i * i + k * k)), b * 2 * (j * k + i * w), 0,
        c * 2 * (i * k + j * w), c * 2 * (j * k - i * w), c * (1 - 2 * (i * i + j * j)), 0, x, y, z, 1]);
    const minus = (a, b) => a.map((x, i) => x - b[i]);
    const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
    const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
    const unit = a => a.map(x => x / Math.hypot(...a));
    const looking = (eye, target) => {
        const back = unit(minus(eye, target)), right = unit(cross([0, 1, 0], back)), up = cross(back, right);
        return new Float32Array([right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
            -dot(right, eye), -dot(up, eye), -dot(back, eye), 1]);
    };
    const opened = (angle, aspect, near, far) => {
        const f = 1 / Math.tan(angle / 2);
        return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) / (near - far), -1,
            0, 0, 2 * near * far / (near - far), 0]);
    };

    // --- drawing ---------------------------------------------------------------------------------------------------
    const vertex_text = `#version 300 es
        in vec3 position, normal;
        uniform mat4 clip_from_world, world_from_part;
        out vec3 n, p;
        void main() {
            p = (world_from_part * vec4(position, 1)).xyz;
            n = transpose(inverse(mat3(world_from_part))) * normal;
            gl_Position = clip_from_world * vec4(p, 1);
        }`;
    const fragment_text = `#version 300 es
        precision highp float;
        in vec3 n, p;
        uniform vec3 to_sun, eye, color;
        uniform float haze;
        out vec4 pixel;
        void main() {
            vec3 normal = normalize(n);
            vec3 light = color * (0.9 * max(dot(normal, to_sun), 0.0) + 0.35 + 0.2 * normal.y);
            float far = 1.0 - exp(-pow(distance(p, eye) / haze, 2.0));
            pixel = vec4(pow(mix(light, vec3(0.028, 0.04, 0.06), far), vec3(1.0 / 2.2)), 1);
        }`;
    const program_of = gl => {
        const program = gl.createProgram();
        for (const [kind, text] of [[gl.VERTEX_SHADER, vertex_text], [gl.FRAGMENT_SHADER, fragment_text]]) {
            const shader = gl.createShader(kind);
            gl.shaderSource(shader, text);
            gl.compileShader(shader);
            gl.attachShader(program, shader);
        }
        gl.linkProgram(program);
        if (!gl.getProgramParameter(program, gl.LINK_STATUS))
            throw new Error(gl.getProgramInfoLog(program));
        return program;
    };

    // Meshes on the card, by glTF's number.
    const upload = (gl, program, model) => model.json.meshes.map(mesh => {
        const {attributes, indices, material} = mesh.primitives[0];
        const array = gl.createVertexArray();
        gl.bindVertexArray(array);
        for (const [name, key] of [['position', 'POSITION'], ['normal', 'NORMAL']]) {
            gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
            gl.bufferData(gl.ARRAY_BUFFER, model.values(attributes[key]), gl.STATIC_DRAW);
            const place = gl.getAttribLocation(program, name);
            gl.enableVertexAttribArray(place);
            gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
        }
        const corners = model.values(indices);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
        return {array, count: corners.length,
            color: model.json.materials[material].pbrMetallicRoughness.baseColorFactor?.slice(0, 3) || [1, 1, 1]};
    });

    // World matrices of all nodes at a time, by number.
    const poses_at = (model, time) => {
        const nodes = model.json.nodes.map(node => ({translation: node.translation || [0, 0, 0],
            rotation: node.rotation || [0, 0, 0, 1], scale: node.scale || [1, 1, 1]}));
        for (const channel of model.channels)
            nodes[channel.node][channel.path] = value_at(channel, time);
        const worlds = [];
        const place = (index, parent) => {
            const {translation, rotation, scale} = nodes[index];
            const own = placed(translation, rotation, scale);
            worlds[index] = parent ? product(parent, own) : own;
            for (const child of model.json.nodes[index].children || [])
                place(child, worlds[index]);
        };
        model.json.scenes[0].nodes.forEach(index => place(index, null));
        return worlds;
    };

    // The view of the film's camera at the start; what it is turned about is as far as the bodies that move.
    const first_view = model => {
        const worlds = poses_at(model, 0);
        const at = world => Array.from(world.slice(12, 15));
        const number = model.json.nodes.findIndex(node => node.camera !== undefined);
        const eye = at(worlds[number]), forward = Array.from(worlds[number].slice(8, 11), x => -x);
        const moving = [...new Set(model.channels.map(channel => channel.node))].filter(node => node !== number);
        const depths = moving.map(node => dot(minus(at(worlds[node]), eye), forward)).filter(depth => depth > 0).sort((a, b) => a - b);
        const distance = depths[depths.length >> 1] || 1;
        return {eye, target: eye.map((x, i) => x + distance * forward[i]), distance,
            angle: model.json.cameras[0].perspective.yfov};
    };

    const steer = (canvas, view, changed) => {
        canvas.onpointerdown = event => canvas.setPointerCapture(event.pointerId);
        canvas.onpointermove = event => {
            if (!event.buttons)
                return;
            const arm = minus(view.eye, view.target), length = Math.hypot(...arm);
            const [across, up] = [event.movementX / canvas.clientHeight, event.movementY / canvas.clientHeight];
            const right = unit(cross([0, 1, 0], arm));
            if (event.shiftKey) {
                const above = unit(cross(arm, right));
                const move = right.map((x, i) => length * (up * above[i] - across * x));
                view.eye = view.eye.map((x, i) => x + move[i]);
                view.target = view.target.map((x, i) => x + move[i]);
            } else {
                const turn = Math.atan2(arm[0], arm[2]) - 4 * across;
                const height = Math.min(Math.max(Math.asin(arm[1] / length) + 4 * up, -1.5), 1.5);
                view.eye = [Math.sin(turn) * Math.cos(height), Math.sin(height), Math.cos(turn) * Math.cos(height)]
                    .map((x, i) => view.target[i] + length * x);
            }
            changed();
        };
        canvas.onwheel = event => {
            event.preventDefault();
            const share = Math.exp(0.001 * event.deltaY);
            view.eye = view.eye.map((x, i) => view.target[i] + share * (x - view.target[i]));
            changed();
        };
    };

    // Draws the model at path into the canvas whenever the film's time or the view changes. times: simulated, by tenths
    // of a second of film.
    const show = async (canvas, film, path, times) => {
        const gl = canvas.getContext('webgl2', {antialias: true, preserveDrawingBuffer: true});
        if (!gl)
            throw new Error('this browser has no WebGL 2');
        const model = parse(await load(path));
        const program = program_of(gl), meshes = upload(gl, program, model), view = first_view(model);
        const place = name => gl.getUniformLocation(program, name);
        const places = Object.fromEntries(['clip_from_world', 'world_from_part', 'to_sun', 'eye', 'color', 'haze'].map(n => [n, place(n)]));
        const sun = model.json.nodes.findIndex(node => node.extensions);
        let shown = '', is_changed = true;
        const draw = () => {
            const width = canvas.clientWidth * devicePixelRatio, height = canvas.clientHeight * devicePixelRatio;
            const tenth = Math.min(film.currentTime * 10, times.length - 1), k = Math.floor(tenth);
            const time = times[k] + (tenth - k) * ((times[k + 1] ?? times[k]) - times[k]);
            const now = `${width} ${height} ${time}`;
            requestAnimationFrame(draw);
            if (now === shown && !is_changed)
                return;
            [shown, is_changed] = [now, false];
            [canvas.width, canvas.height] = [width, height];
            canvas.dataset.time = time;
            gl.viewport(0, 0, width, height);
            gl.enable(gl.DEPTH_TEST);
            gl.clearColor(0.197, 0.232, 0.278, 1);   // the haze
            gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
            gl.useProgram(program);
            const worlds = poses_at(model, time);
            const reach = Math.hypot(...minus(view.eye, view.target));
            const clip = product(opened(view.angle, width / height, 0.01 * reach, 100 * reach), looking(view.eye, view.target));
            gl.uniformMatrix4fv(places.clip_from_world, false, clip);
            gl.uniform3fv(places.to_sun, unit(Array.from(worlds[sun].slice(8, 11))));
            gl.uniform3fv(places.eye, view.eye);
            gl.uniform1f(places.haze, 6 * view.distance);
            model.json.nodes.forEach((node, index) => {
                if (node.mesh === undefined)
                    return;
                const mesh = meshes[node.mesh];
                gl.bindVertexArray(mesh.array);
                gl.uniformMatrix4fv(places.world_from_part, false, worlds[index]);
                gl.uniform3fv(places.color, mesh.color);
                gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_INT, 0);
            });
        };
        steer(canvas, view, () => is_changed = true);
        draw();
    };

    // A button opens the model under the film, and closes it.
    document.addEventListener('click', event => {
        const button = event.target.closest('[data-model]');
        if (!button)
            return;
        const film = button.closest('.run').querySelector('video');
        if (button.nextElementSibling?.tagName === 'CANVAS') {
            button.nextElementSibling.hidden = !button.nextElementSibling.hidden;
            return;
        }
        const canvas = document.createElement('canvas');
        canvas.title = 'drag: turn; shift and drag: move; wheel: nearer';
        button.after(canvas);
        show(canvas, film, button.dataset.model, JSON.parse(button.dataset.times))
            .catch(error => { canvas.remove(); button.textContent = error.message; });
    });

    return {arrived};
})();
