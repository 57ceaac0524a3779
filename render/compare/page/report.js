const report = JSON.parse(document.getElementById('result').textContent);
const by_id = id => document.getElementById(id);

// ---- data
// Severity, worst first; the names are tiers of the report, and one for all that could not be compared.
const outcomes = ['not_compared', 'changed', 'noise', 'identical'];
const words = {
    all: 'all',
    not_compared: 'not compared',
    changed: 'changed',
    noise: 'noise',
    identical: 'identical',
    size_differs: 'size differs',
    reference_missing: 'reference missing',
    candidate_missing: 'candidate missing',
    unreadable: 'unreadable',
};
const signs = {
    not_compared: '!',
    changed: '✕',
    noise: '≈',
    identical: '✓'
};
const outcome = item => item.status === 'compared' ? item.tier : 'not_compared';
const word = item => item.status === 'compared' ? words[item.tier] : words[item.status];
const sorted_cases =
    report.cases.map((item, index) => ({item, index}))
        .sort(
            (a, b) =>
                outcomes.indexOf(outcome(a.item)) - outcomes.indexOf(outcome(b.item)) || a.index - b.index);

const inlined = new Map(Array.from(document.querySelectorAll('script.picture'), e => [e.dataset.path, e]));
const link_to = path => path.split('/').map(encodeURIComponent).join('/');
function source_of(path) {
    const element = inlined.get(path);
    const type = /\.jpe?g$/i.test(path) ? 'image/jpeg' : 'image/png';
    return element ? `data:${type};base64,` + element.textContent : link_to(path);
}
const sides = ['reference', 'candidate', 'difference'];
const picture_of = (frame, side) => frame[side + '_picture'];
const has_picture = frame => sides.some(side => picture_of(frame, side));

const state = {
    tier: 'all',
    text: '',
    case: -1,
    frame: 0,
    mode: 'three',
    showing: 'reference',
    outlines: true,
    split: 0.5
};
const view = {
    scale: 1,
    x: 0,
    y: 0,
    fits: true
};
let mark = null;   // pixel {x, y} whose values are shown, chosen by a click
let blinking = 0;  // timer
let samples = {};  // side -> {width, height, data} or null, of the present frame

const the_case = () => report.cases[state.case];
const the_frame = () => the_case().frames[state.frame];

// ---- small tools
function make(tag, attributes, ...children) {
    const element = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes || {})) {
        if (key.startsWith('on'))
            element.addEventListener(key.slice(2), value);
        else if (key.startsWith('aria-'))
            element.setAttribute(key, value);
        else if (value === true)
            element.setAttribute(key, '');
        else if (value !== false && value !== undefined)
            element.setAttribute(key, value);
    }
    element.append(...children);
    return element;
}
function svg(tag, attributes, text) {
    const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    if (text !== undefined)
        element.textContent = text;
    return element;
}
const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
const count_of = (n, noun) => n + ' ' + noun + (n === 1 ? '' : 's');
const is_typing = () => ['INPUT', 'SELECT', 'TEXTAREA'].includes(document.activeElement.tagName);
function number(value) {
    if (value === null || value === undefined)
        return '–';
    if (Number.isInteger(value))
        return value.toLocaleString('en');
    const size = Math.abs(value);
    return size >= 1e5 || size < 1e-3 ? value.toExponential(2) : value.toPrecision(3).replace(/\.?0+$/, '');
}
const signed = value => (value > 0 ? '+' : value < 0 ? '−' : '±') + number(Math.abs(value));

// ---- summary and list
const counts = {
    all: report.cases.length
};
for (const name of outcomes) counts[name] = report.cases.filter(item => outcome(item) === name).length;

function show_summary() {
    const failed = report.cases.filter(item => item.is_failed).length;
    const total = count_of(counts.all, 'case');
    by_id('verdict').textContent = failed === 0 ? `✓ Passed: ${total}` : `✕ Failed: ${failed} of ${total}`;
    by_id('verdict').className = 'tier ' + (failed === 0 ? 'identical' : 'changed');
    document.title = (failed === 0 ? 'passed' : failed + ' failed') + ' – comparison';
    const parts = outcomes.filter(name => counts[name]).map(name => `${counts[name]} ${words[name]}`);
    by_id('proportions').setAttribute('aria-label', parts.join(', '));
    const bar = name => make('span', {
        class: 'fill ' + name,
        style: `flex-grow:${counts[name]}`,
        title: `${counts[name]} ${words[name]}`
    });
    by_id('proportions').replaceChildren(...outcomes.filter(name => counts[name]).map(bar));
    by_id('command').title = report.command;
    by_id('command').replaceChildren(
        make('code', {}, report.command),
        `  ·  fails on ${report.fail_on}  ·  exit code ${report.exit_code}  ·  ${report.program}`);
}

function show_filter() {
    const choice = name => {
        const choose = () => {
            state.tier = name;
            show_filter();
            filter_list();
        };
        const attributes =
            {type: 'button', 'data-tier': name, 'aria-pressed': state.tier === name, onclick: choose};
        const sign = signs[name] ? signs[name] + ' ' : '';
        return make('button', attributes, `${sign}${words[name]} ${counts[name]}`);
    };
    by_id('tiers').replaceChildren(
        ...['all', ...outcomes].filter(name => name === 'all' || counts[name]).map(choice));
}

const is_visible = item => (state.tier === 'all' || outcome(item) === state.tier) &&
    item.name.toLowerCase().includes(state.text.toLowerCase());
const visible_cases = () => sorted_cases.filter(({item}) => is_visible(item)).map(({index}) => index);

function list_row({item, index}) {
    const frame = item.frames[start_frame(item)];
    const path = frame && (picture_of(frame, 'candidate') || picture_of(frame, 'reference'));
    const thumb = path ? make('img', {class: 'thumb', alt: '', loading: 'lazy', src: source_of(path)}) :
                         make('span', {class: 'thumb tier'}, signs[outcome(item)]);
    const count = (item.is_flaky ? ' · flaky' : '') +
        (item.is_sequence ? ` · ${count_of(item.frames.length, 'frame')}` : '');
    const why = make('span', {class: 'why'},
                     make('span', {class: 'tier'}, `${signs[outcome(item)]} ${word(item)}`),
                     `${count} · ${item.message}`);
    const button = make('button', {type: 'button', 'data-case': index, onclick: () => open_case(index)}, thumb,
                        make('span', {class: 'case_name'}, item.name), why);
    const tick = {type: 'checkbox', 'aria-label': `accept ${item.name}`, onchange: event => tick_case(index, event.target.checked)};
    return make('li', {class: outcome(item)}, ...(can_accept(item) ? [make('input', tick)] : []), button);
}

// ---- the command that makes what was reviewed the baselines
const can_accept = item => Boolean(report.accept) && report.cases.length > 1 && outcome(item) !== 'identical';
const ticked = new Set();
const shell_word = text => /^[\w./@%+=:,-]+$/.test(text) ? text : `'${text.replaceAll("'", `'\\''`)}'`;

function tick_case(index, is_ticked) {
    if (is_ticked)
        ticked.add(index);
    else
        ticked.delete(index);
    show_accept();
}

function show_accept() {
    const changed = report.cases.filter(item => outcome(item) !== 'identical').length;
    by_id('accept').hidden = !report.accept || changed === 0;
    const names = [...ticked].sort((a, b) => a - b).map(index => ' ' + shell_word(report.cases[index].name));
    const what = names.length > 0 ? `accepts the ${names.length} ticked` :
        report.cases.length > 1   ? `accepts all ${changed}; tick some for these only` :
                                    'accepts it';
    by_id('accept').replaceChildren(make('code', {}, report.accept + names.join('')), what);
}

function filter_list() {
    sorted_cases.forEach(({item}, place) => {
        by_id('cases').children[place].hidden = !is_visible(item);
    });
    by_id('none').hidden = visible_cases().length > 0;
}

// ---- one case
function start_frame(item) {
    const worst = item.worst_frame === null ? 0 : index_at(item, item.worst_frame);
    const shown = item.frames.findIndex(has_picture);
    return shown < 0 || has_picture(item.frames[worst]) ? worst : shown;
}
const index_at = (item, number_of_frame) =>
    Math.max(0, item.frames.findIndex(frame => frame.index === number_of_frame));

function open_case(index, frame) {
    state.case = index;
    state.frame =
        frame === undefined ? start_frame(the_case()) : clamp(frame, 0, the_case().frames.length - 1);
    view.fits = true;
    mark = null;
    document.body.classList.add('in_case');
    for (const button of by_id('cases').querySelectorAll('button'))
        button.setAttribute('aria-current', Number(button.dataset.case) === index);
    by_id('cases').querySelector('[aria-current=true]')?.scrollIntoView({block: 'nearest'});
    by_id('case').hidden = false;
    show_case();
    if (matchMedia('(max-width: 820px)').matches)
        window.scrollTo(0, 0);
}

function close_case() {
    if (report.cases.length === 1)
        return;
    document.body.classList.remove('in_case');
    history.replaceState(null, '', '#');
    by_id('cases').querySelector('[aria-current=true]')?.focus();
}

function step_case(by) {
    const order = visible_cases();
    if (order.length === 0)
        return;
    const at = order.indexOf(state.case);
    open_case(order[at < 0 ? 0 : clamp(at + by, 0, order.length - 1)]);
}

function show_case() {
    const item = the_case();
    by_id('badge').className = outcome(item);
    by_id('badge').textContent = `${signs[outcome(item)]} ${word(item)}`;
    by_id('name').textContent = item.name;
    by_id('message').textContent = item.message;
    by_id('cause').hidden = !item.cause_text;
    by_id('cause').textContent = item.cause_text;
    const order = visible_cases();
    by_id('case_before').disabled = order.indexOf(state.case) <= 0;
    by_id('case_after').disabled = order.indexOf(state.case) === order.length - 1;
    by_id('sequence').hidden = !item.is_sequence;
    if (item.is_sequence)
        show_sequence();
    show_film();
    show_frame();
}

// ---- frames of a sequence
function show_sequence() {
    const item = the_case();
    const jump = (label, frame, title) =>
        make('button', {type: 'button', title, onclick: () => go_to_frame(index_at(item, frame))}, label);
    const jumps = [];
    if (item.first_bad_frame !== null)
        jumps.push(jump(`First bad: ${item.first_bad_frame}`, item.first_bad_frame, 'First bad frame (F)'));
    if (item.worst_frame !== null)
        jumps.push(jump(`Worst: ${item.worst_frame}`, item.worst_frame, 'Worst frame (W)'));
    for (const [begin, end] of item.bad_runs.slice(0, 6))
        jumps.push(jump(
            end - begin === 1 ? `bad ${begin}` : `bad ${begin}–${end - 1}`, begin, 'A run of bad frames'));
    if (item.bad_runs.length > 6)
        jumps.push(make('span', {class: 'muted'}, `and ${item.bad_runs.length - 6} more runs`));
    by_id('jumps').replaceChildren(...jumps);
    draw_curve();
    const thumb = (frame, index) => {
        const path = picture_of(frame, 'candidate') || picture_of(frame, 'reference');
        const attributes = {
            type: 'button',
            class: outcome(frame),
            'data-frame': index,
            title: frame.message,
            onclick: () => go_to_frame(index)
        };
        return path ? [make('button', attributes, make('img', {alt: '', loading: 'lazy', src: source_of(path)}),
                            `${signs[outcome(frame)]} ${frame.index}`)] :
                      [];
    };
    by_id('strip').replaceChildren(...item.frames.flatMap(thumb));
}

// Largest value / limit of a frame's gates over the frames, logarithmic: 1 is the limit.
function draw_curve() {
    const item = the_case();
    const width = Math.max(200, by_id('curve').clientWidth), height = 118, left = 40, foot = 16;
    const top = Math.max(2, ...item.frames.map(frame => frame.curve || 0));
    const x_of = index => left + (index + 0.5) * (width - left - 8) / item.frames.length;
    const y_of = value => height - foot - (height - foot - 8) * Math.log1p(value) / Math.log1p(top);
    const picture = svg('svg', {viewBox: `0 0 ${width} ${height}`, 'aria-hidden': true});
    const thickness = clamp((width - left) / item.frames.length - 1, 1, 14);
    const top_of = frame => outcome(frame) === 'not_compared' ?
        8 :
        Math.min(y_of(frame.curve || 0), height - foot - 2);
    for (const name of outcomes) {
        const bars = item.frames.map(
            (frame, index) => outcome(frame) === name ?
                `M${x_of(index).toFixed(1)} ${height - foot}V${top_of(frame).toFixed(1)}` :
                '');
        const opacity = name === 'not_compared' ? 0.45 : 1;
        picture.append(svg('path', {
            class: name,
            d: bars.join(''),
            'stroke-width': thickness,
            'stroke-opacity': opacity
        }));
    }
    const limit = y_of(1).toFixed(1);
    picture.append(
        svg('line', {class: 'limit', x1: left, x2: width, y1: limit, y2: limit}),
        svg('text', {x: 4, y: Number(limit) + 4}, 'limit'), svg('text', {x: 4, y: 15}, number(top) + '×'),
        svg('text', {x: left, y: height - 3}, String(item.frames[0]?.index ?? 0)),
        svg('text', {x: width - 8, y: height - 3, 'text-anchor': 'end'},
            `frame ${item.frames.at(-1)?.index ?? 0}`),
        svg('line', {class: 'here', y1: 2, y2: height - foot}));
    by_id('curve').replaceChildren(picture);
    by_id('curve').index_at = x =>
        clamp(Math.floor((x - left) * item.frames.length / (width - left - 8)), 0, item.frames.length - 1);
    by_id('curve').x_of = x_of;
}

function show_frame_place() {
    const item = the_case(), frame = the_frame();
    const here = by_id('curve').querySelector('.here');
    for (const end of ['x1', 'x2']) here.setAttribute(end, by_id('curve').x_of(state.frame));
    by_id('curve').setAttribute('aria-valuemax', item.frames.length - 1);
    by_id('curve').setAttribute('aria-valuenow', state.frame);
    by_id('frame_label')
        .replaceChildren(
            make('span', {class: 'tier ' + outcome(frame)}, signs[outcome(frame)] + ' '),
            `frame ${frame.index}`,
            make('span', {class: 'muted'}, `  ${state.frame + 1} of ${item.frames.length}`));
    // The table of gates says the same at length.
    by_id('frame_message').textContent = frame.gates.length > 0 ? '' : frame.message;
    by_id('frame_before').disabled = state.frame === 0;
    by_id('frame_after').disabled = state.frame === item.frames.length - 1;
    for (const button of by_id('strip').children) {
        const is_here = Number(button.dataset.frame) === state.frame;
        button.setAttribute('aria-current', is_here);
        if (is_here)
            by_id('strip').scrollLeft =
                button.offsetLeft - by_id('strip').offsetLeft - by_id('strip').clientWidth / 2 + 46;
    }
}

function go_to_frame(index) {
    const clamped = clamp(index, 0, the_case().frames.length - 1);
    if (clamped === state.frame)
        return;
    state.frame = clamped;
    show_frame();
}

function show_frame() {
    const item = the_case();
    if (item.frames.length > 0 && item.is_sequence)
        show_frame_place();
    const frame = the_frame();
    const shows = frame !== undefined && has_picture(frame);
    by_id('viewer').hidden = !shows;
    by_id('no_picture').hidden = shows;
    by_id('no_picture').textContent = frame === undefined ?
        'There is no frame.' :
        frame.status === 'compared' && frame.tier === 'identical' ?
        'Every pixel is the same; no picture is kept.' :
        'No picture of this frame is kept: the worst frames have theirs.';
    if (!blinking && item.film && by_id('video').paused && frame)
        by_id('video').currentTime = (state.frame + 0.5) / item.fps;
    if (shows) {
        build_panes();
        read_samples(frame);
    }
    show_facts();
    const place = `#case=${state.case}` + (item.is_sequence ? `&frame=${state.frame}` : '');
    if (location.hash !== place)
        history.replaceState(null, '', place);
}

// ---- film
function show_film() {
    const item = the_case(), video = by_id('video');
    by_id('film').hidden = !item.film;
    const wanted = item.film ? link_to(item.film) : '';
    if (video.getAttribute('src') === wanted)
        return;
    video.pause();
    if (wanted)
        video.src = wanted;
    else
        video.removeAttribute('src');
    by_id('film_time').textContent = '';
}
function film_moved() {
    const item = the_case(), video = by_id('video');
    if (!item || !item.film)
        return;
    const frame = Math.floor(video.currentTime * item.fps + 1e-3);
    by_id('film_time').textContent = `frame ${item.frames[frame]?.index ?? frame}`;
    if (!video.paused && item.is_sequence) {
        const here = by_id('curve').querySelector('.here');
        for (const end of ['x1', 'x2']) here?.setAttribute(end, by_id('curve').x_of(frame));
    }
}
