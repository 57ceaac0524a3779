// ---- pictures
const modes = [
    ['three', 'All three', 'A'], ['swipe', 'Swipe', 'P'], ['blink', 'Blink', 'B'],
    ['difference', 'Difference', 'D'], ['reference', 'Reference', 'R'], ['candidate', 'Candidate', 'C']
];
const size_of = frame => ({
    width: Math.max(frame.width, frame.candidate_width, 1),
    height: Math.max(frame.height, frame.candidate_height, 1)
});

function layer(frame, side) {
    const path = picture_of(frame, side);
    return path ? make('img', {alt: side, class: 'layer ' + side, src: source_of(path), draggable: 'false'}) :
                  make('div', {class: 'empty ' + side}, `no ${side} picture`);
}

// The captions stand above the picture: over it they would hide its text.
function pane_of(frame, mode) {
    const pane = make('div', {class: 'pane', 'data-side': mode});
    const captions = make('figcaption', {});
    const caption = text => captions.append(make('span', {class: 'caption'}, text));
    if (mode === 'swipe') {
        pane.classList.add('swiped');
        const divider = {class: 'divider', role: 'slider', tabindex: 0, 'aria-label': 'Divider'};
        pane.append(layer(frame, 'candidate'), make('div', {class: 'clip'}, layer(frame, 'reference')), make('div', divider));
        caption('reference');
        caption('candidate');
    } else if (mode === 'blink') {
        pane.append(layer(frame, 'reference'), layer(frame, 'candidate'));
        caption('');
    } else {
        pane.append(layer(frame, mode));
        caption(mode);
    }
    return make('figure', {}, captions, pane);
}

function build_panes() {
    const frame = the_frame();
    const available = name => sides.includes(name) ?
        Boolean(picture_of(frame, name)) :
        name === 'three' || Boolean(frame.reference_picture && frame.candidate_picture);
    if (!available(state.mode))
        state.mode = 'three';
    const choice = ([name, label, key]) => {
        const attributes = {
            type: 'button',
            'data-mode': name,
            title: `${label} (${key})`,
            'aria-pressed': state.mode === name,
            disabled: !available(name),
            onclick: () => set_mode(name)
        };
        return make('button', attributes, label);
    };
    by_id('modes').replaceChildren(...modes.map(choice));
    by_id('panes').className = state.mode;
    by_id('panes').replaceChildren(
        ...(state.mode === 'three' ? sides : [state.mode]).map(mode => pane_of(frame, mode)));
    clearInterval(blinking);
    blinking = 0;
    if (state.mode === 'blink')
        start_blinking();
    place_all();
}

function set_mode(name) {
    const centre = view.fits ? null : world_at(pane_size().width / 2, pane_size().height / 2);
    state.mode = name;
    build_panes();
    if (centre) {
        view.x = pane_size().width / 2 - centre.x * view.scale;
        view.y = pane_size().height / 2 - centre.y * view.scale;
        place_all();
    }
}

function start_blinking() {
    const period = matchMedia('(prefers-reduced-motion: reduce)').matches ? 1500 : 600;
    clearInterval(blinking);
    blinking = setInterval(flip, period);
    show_blink();
}
function flip() {
    state.showing = state.showing === 'reference' ? 'candidate' : 'reference';
    show_blink();
}
function show_blink() {
    const pane = by_id('panes').querySelector('.pane');
    for (const side of ['reference', 'candidate'])
        pane.querySelector('.' + side).style.visibility = side === state.showing ? 'visible' : 'hidden';
    by_id('panes').querySelector('.caption').textContent = state.showing + (blinking ? '' : ' (held)');
}

const first_pane = () => by_id('panes').querySelector('.pane');
const pane_size = () => ({width: first_pane().clientWidth, height: first_pane().clientHeight});
const world_at = (x, y) => ({x: (x - view.x) / view.scale, y: (y - view.y) / view.scale});

// Puts every layer, outline and mark of all panes where the view says.
function place_all() {
    const frame = the_frame(), size = size_of(frame), panes = by_id('panes').querySelectorAll('.pane');
    const height = clamp(panes[0].clientWidth * size.height / size.width, 120, window.innerHeight * 0.72);
    for (const pane of panes) pane.style.height = `${Math.round(height)}px`;
    const fit = Math.min(panes[0].clientWidth / size.width, height / size.height);
    if (view.fits) {
        view.scale = fit;
        view.x = (panes[0].clientWidth - size.width * fit) / 2;
        view.y = (height - size.height * fit) / 2;
    }
    by_id('panes').classList.toggle('zoomed', !view.fits);
    by_id('zoom_label').textContent = `${number(Math.round(view.scale * 1000) / 10)} %`;
    for (const image of by_id('panes').querySelectorAll('.layer')) {
        image.style.transform = `translate(${view.x}px, ${view.y}px) scale(${view.scale})`;
        image.style.imageRendering = view.scale >= 1.5 ? 'pixelated' : 'auto';
    }
    for (const old of by_id('panes').querySelectorAll('.outline, .mark')) old.remove();
    const boxes =
        state.outlines ? frame.clusters.filter(c => c.kind !== 'noise').map(c => [c.box, 'outline', 2]) : [];
    if (mark)
        boxes.push([[mark.x, mark.y, 1, 1], 'mark', 0]);
    for (const pane of panes) {
        for (const [[x, y, across, down], name, margin] of boxes) {
            const box = make('div', {class: name});
            box.style.left = `${view.x + x * view.scale - margin}px`;
            box.style.top = `${view.y + y * view.scale - margin}px`;
            box.style.width = `${across * view.scale + 2 * margin}px`;
            box.style.height = `${down * view.scale + 2 * margin}px`;
            pane.append(box);
        }
    }
    if (state.mode === 'swipe')
        place_divider();
}

function place_divider() {
    const pane = first_pane(), divider = pane.querySelector('.divider');
    pane.querySelector('.clip').style.width = `${state.split * 100}%`;
    divider.style.left = `${state.split * 100}%`;
    divider.setAttribute('aria-valuenow', Math.round(state.split * 100));
}

function zoom_at(x, y, factor) {
    const before = world_at(x, y);
    view.scale = clamp(view.scale * factor, 0.02, 64);
    view.x = x - before.x * view.scale;
    view.y = y - before.y * view.scale;
    view.fits = false;
    place_all();
}
function zoom(how) {
    const {width, height} = pane_size();
    if (how === 'fit') {
        view.fits = true;
        place_all();
    } else
        zoom_at(width / 2, height / 2, how === 'one' ? 1 / view.scale : how === 'in' ? 1.5 : 1 / 1.5);
}
function zoom_to([x, y, width, height]) {
    const pane = pane_size();
    view.scale = clamp(Math.min(pane.width / (width * 1.8 + 8), pane.height / (height * 1.8 + 8)), 0.05, 24);
    view.x = pane.width / 2 - (x + width / 2) * view.scale;
    view.y = pane.height / 2 - (y + height / 2) * view.scale;
    view.fits = false;
    place_all();
    by_id('viewer').scrollIntoView({block: 'nearest'});
}

// ---- pixel values
function read_samples(frame) {
    samples = {};
    by_id('readout').replaceChildren(make(
        'span', {class: 'muted'},
        'Point at a pixel or tap it to read its values; drag to move, click and scroll to zoom.'));
    for (const side of ['reference', 'candidate']) {
        const path = picture_of(frame, side);
        if (!path)
            continue;
        const image = new Image();
        image.onload = () => {
            if (frame !== the_frame())
                return;
            const canvas = make('canvas', {width: image.naturalWidth, height: image.naturalHeight});
            const context = canvas.getContext('2d', {willReadFrequently: true});
            context.drawImage(image, 0, 0);
            try {
                samples[side] = context.getImageData(0, 0, canvas.width, canvas.height);
            } catch (refused) {
                samples[side] =
                    null;  // a picture beside a page opened as a file: browsers keep its pixels from it
            }
            if (mark)
                show_pixel(mark);
        };
        image.src = source_of(path);
    }
}

function color_at(side, x, y) {
    const picture = samples[side];
    if (!picture || x < 0 || y < 0 || x >= picture.width || y >= picture.height)
        return null;
    return Array.from(picture.data.slice((y * picture.width + x) * 4, (y * picture.width + x) * 4 + 3));
}

function show_pixel({x, y}) {
    const parts = [make('span', {}, `x ${x}, y ${y}`)];
    const colors = ['reference', 'candidate'].map(side => {
        const color = color_at(side, x, y);
        const swatch = color ? [make('span', {class: 'swatch', style: `background:rgb(${color})`})] : [];
        const text = color         ? color.join(' ') :
            samples[side] === null ? 'open this page over http, or make it with --one-page, to read values' :
                                     '–';
        parts.push(make('span', {class: side}, make('span', {class: 'muted'}, side + ' '), ...swatch, text));
        return color;
    });
    if (colors[0] && colors[1]) {
        const change = colors[0].map((value, i) => colors[1][i] - value);
        parts.push(make(
            'span', {class: 'change'}, make('span', {class: 'muted'}, 'change '),
            change.every(value => value === 0) ? 'none' : change.map(signed).join(' ')));
    }
    by_id('readout').replaceChildren(...parts);
}

function set_mark(pixel) {
    mark = pixel;
    show_pixel(mark);
    place_all();
}

// ---- pointer
const pointers = new Map();
let gesture = null;  // {kind: 'pan' | 'swipe' | 'pinch', moved, ...}

const pane_point = (event, pane) => {
    const box = pane.getBoundingClientRect();
    return {x: event.clientX - box.left, y: event.clientY - box.top};
};
const pixel_at = point => {
    const world = world_at(point.x, point.y);
    return {x: Math.floor(world.x), y: Math.floor(world.y)};
};
const is_inside = ({x, y}) =>
    x >= 0 && y >= 0 && x < size_of(the_frame()).width && y < size_of(the_frame()).height;
const spread = () => {
    const [a, b] = Array.from(pointers.values());
    return {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, distance: Math.hypot(a.x - b.x, a.y - b.y)};
};

function pointer_down(event) {
    const pane = event.target.closest('.pane');
    if (!pane || event.button > 0)
        return;
    const point = pane_point(event, pane);
    pointers.set(event.pointerId, point);
    by_id('panes').setPointerCapture(event.pointerId);
    if (pointers.size === 2)
        gesture = {kind: 'pinch', pane, moved: true, ...spread()};
    else if (pointers.size === 1) {
        const swipes = state.mode === 'swipe' && (view.fits || event.target.closest('.divider'));
        gesture = {kind: swipes ? 'swipe' : 'pan', pane, moved: false, start: point, x: view.x, y: view.y};
    }
}
function pointer_move(event) {
    if (!gesture) {
        const pane = event.target.closest('.pane');
        if (pane && !mark && event.pointerType === 'mouse') {
            const pixel = pixel_at(pane_point(event, pane));
            if (is_inside(pixel))
                show_pixel(pixel);
        }
        return;
    }
    if (!pointers.has(event.pointerId))
        return;
    const point = pane_point(event, gesture.pane);
    pointers.set(event.pointerId, point);
    if (gesture.kind === 'pinch' && pointers.size === 2) {
        const now = spread();
        view.x += now.x - gesture.x;
        view.y += now.y - gesture.y;
        zoom_at(now.x, now.y, now.distance / Math.max(1, gesture.distance));
        Object.assign(gesture, now);
        return;
    }
    if (Math.hypot(point.x - gesture.start.x, point.y - gesture.start.y) > 3)
        gesture.moved = true;
    if (!gesture.moved)
        return;
    if (gesture.kind === 'swipe') {
        state.split = clamp(point.x / pane_size().width, 0, 1);
        place_divider();
    } else if (gesture.kind === 'pan' && !(view.fits && event.pointerType === 'touch')) {
        view.x = gesture.x + point.x - gesture.start.x;
        view.y = gesture.y + point.y - gesture.start.y;
        view.fits = false;
        place_all();
    }
}
function pointer_up(event) {
    pointers.delete(event.pointerId);
    if (gesture && !gesture.moved && event.type === 'pointerup') {
        const pixel = pixel_at(gesture.start);
        if (is_inside(pixel)) {
            if (mark && mark.x === pixel.x && mark.y === pixel.y) {
                mark = null;
                place_all();
            } else
                set_mark(pixel);
        }
    }
    if (pointers.size === 0)
        gesture = null;
}
function wheel(event) {
    const pane = event.target.closest('.pane');
    // A page that scrolls past the pictures goes on; a click into them, or Ctrl, makes the wheel zoom.
    if (!pane || !(event.ctrlKey || document.activeElement === by_id('panes')))
        return;
    event.preventDefault();
    const point = pane_point(event, pane);
    zoom_at(point.x, point.y, Math.exp(-clamp(event.deltaY, -240, 240) / 400));
}
