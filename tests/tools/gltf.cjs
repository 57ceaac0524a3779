// Usage: node gltf.cjs FILE.glb FRAME TIME, see gltf.sh. FRAME: a picture without .png, its .bodies.png and .bodies.json beside
// it; TIME [s]: of the picture. Prints a page that draws the file with three.js in flat colours that number the bodies, and
// counts the pixels that show another body than the picture. Exit code 1 if the validator has anything to say.
const fs = require("fs");
const path = require("path");
const validator = require(path.resolve("node_modules/gltf-validator"));
const [glb, frame, time] = process.argv.slice(2);
const bytes = fs.readFileSync(glb);
const names = JSON.parse(fs.readFileSync(frame + ".bodies.json")).names;

const draw = `
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const width = 640, height = 360, most = 0.002;
const sheet = document.createElement("canvas"); // ours, theirs, what differs
sheet.width = 3 * width;
sheet.height = height;
const context = sheet.getContext("2d");
const picture = async (url) => {
    const image = new Image();
    image.src = url;
    await image.decode();
    context.drawImage(image, 0, 0);
    return context.getImageData(0, 0, width, height).data;
};
const ours = await picture(page.frame + ".bodies.png");
await picture(page.frame + ".png");

const gltf = await new GLTFLoader().loadAsync(page.glb);
const mixer = new THREE.AnimationMixer(gltf.scene);
gltf.animations.forEach((clip) => mixer.clipAction(clip).play());
mixer.setTime(page.time);
const number = new Map(page.names.map((name, i) => [name, i + 1]));
const lit = new Map();
let floor = 0; // of four corners; where it ends is not compared: ours fades
gltf.scene.traverse((node) => {
    if (!node.isMesh) return;
    let body = node;
    while (!number.has(body.userData.name ?? body.name)) body = body.parent;
    const id = node.name.startsWith("rod") ? 0 : number.get(body.userData.name ?? body.name); // a rod is of no body
    floor = node.geometry.attributes.position.count === 4 ? id : floor;
    lit.set(node, node.material);
    node.material = new THREE.ShaderMaterial({
        vertexShader: "void main() { gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }",
        fragmentShader: "uniform vec3 color; void main() { gl_FragColor = vec4(color, 1.0); }",
        uniforms: { color: { value: new THREE.Vector3(id & 255, (id >> 8) & 255, id >> 16).divideScalar(255) } },
    });
});
const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
renderer.setSize(width, height);
renderer.setClearColor(0x000000);
const target = new THREE.WebGLRenderTarget(width, height);
renderer.setRenderTarget(target);
renderer.render(gltf.scene, gltf.cameras[0]);
const theirs = new Uint8Array(4 * width * height);
renderer.readRenderTargetPixels(target, 0, 0, width, height, theirs);
renderer.setRenderTarget(null);
lit.forEach((material, node) => { node.material = material; });
gltf.scene.add(new THREE.HemisphereLight(0xffffff, 0x444444, 1));
renderer.render(gltf.scene, gltf.cameras[0]);
context.drawImage(renderer.domElement, width, 0);

const marks = context.createImageData(width, height);
let different = 0;
for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
        const a = 4 * (y * width + x), b = 4 * ((height - 1 - y) * width + x);
        const [our, their] = [[ours, a], [theirs, b]].map(([from, i]) => from[i] | (from[i + 1] << 8) | (from[i + 2] << 16));
        const same = our === their || [our, their].every((id) => id === floor || id === 0);
        different += same ? 0 : 1;
        marks.data.set(same ? [32, 32, 32, 255] : [255, 80, 80, 255], a);
    }
}
context.putImageData(marks, 2 * width, 0);
const share = different / (width * height);
document.querySelector("#sheet").textContent = sheet.toDataURL("image/png").split(",")[1];
document.querySelector("#verdict").textContent = (share <= most ? "same" : "different") + ", " +
    (100 * share).toFixed(3) + " % of the pixels show another body, limit " + 100 * most + " %";
`;

validator.validateBytes(new Uint8Array(bytes)).then(({ issues }) => {
    if (issues.messages.length > 0) {
        console.error(issues.messages.map((m) => `${glb}: ${m.code}: ${m.message} (${m.pointer})`).join("\n"));
        process.exitCode = 1;
    }
    const page = { glb: "data:model/gltf-binary;base64," + bytes.toString("base64"), frame, time: Number(time), names };
    const imports = { three: "./node_modules/three/build/three.module.js", "three/addons/": "./node_modules/three/examples/jsm/" };
    console.log(`<!doctype html><meta charset="utf-8">
<body><script type="importmap">${JSON.stringify({ imports })}</script>
<script type="module">const page = ${JSON.stringify(page)};${draw}</script><p id="sheet"></p>
<p id="verdict"></p></body>`);
});
