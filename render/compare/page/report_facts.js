// ---- numbers
// A section with a table. A cell is a text, an element, or [class, text or element].
function table_section(title, name, titles, rows) {
    const cell = content => Array.isArray(content) ? make('td', {class: content[0]}, content[1]) :
                                                     make('td', {}, content);
    const head = make('thead', {}, make('tr', {}, ...titles.map(text => make('th', {}, text))));
    const body = make('tbody', {}, ...rows.map(row => make('tr', {class: row.name || ''}, ...row.map(cell))));
    const table = make('table', {class: name}, ...(titles.length ? [head, body] : [body]));
    return make('section', {}, make('h3', {}, title), table);
}

function gate_row(gate) {
    const name = gate.is_exceeded ? 'changed' : 'identical';
    const share = gate.limit > 0 ? gate.value / gate.limit : gate.value > 0 ? 2 : 0;
    const width = `width:${clamp(share * 50, 0, 100)}%`;
    const gauge = make('div', {class: 'gauge', title: `${number(share)} of the limit`},
                       make('span', {class: 'fill ' + name, style: width}));
    const source = gate.source && gate.source !== 'default' ? ` (limit: ${gate.source})` : '';
    return [
        make('span', {class: 'tier ' + name}, `${signs[name]} ${gate.name}`),
        ['number', `${number(gate.value)} ${gate.unit}`],
        ['number', `≤ ${number(gate.limit)} ${gate.unit}`],
        gauge,
        ['reason', gate.reason + source],
    ];
}

function shift_text({x, y}) {
    return x === 0 && y === 0 ? '' : `${signed(x)} px right, ${signed(y)} px down`;
}

function place_link(box) {
    const attributes = {type: 'button', class: 'link', title: 'Zoom there', onclick: () => zoom_to(box)};
    return make('button', attributes, `${box[2]}×${box[3]} at ${box[0]}, ${box[1]}`);
}

function cluster_row({box, kind, bodies, pixels, largest_difference, displacement}) {
    const explained = `explains ${Math.round(displacement.explained * 100)} %`;
    return [
        place_link(box),
        [kind, ...bodies.slice(0, 3)].join(' · '),
        ['number', number(pixels)],
        ['number', `${largest_difference} levels`],
        kind === 'moved' ? `${shift_text(displacement)}; ${explained}` : '',
    ];
}

function body_row({name, kind, displacement, distance, angle, box}) {
    const in_space = [distance ? `${number(distance * 1000)} mm` : '', angle >= 0.05 ? `${number(angle)}°` : '']
        .filter(text => text).join(', ');
    return [name, kind, shift_text(displacement), ['number', in_space], place_link(box)];
}

function origins_section(item) {
    const code = text => make('code', {}, text || '–');
    const titles = {
        program: 'Program',
        scene: 'Scene',
        state_hash: 'State hash',
        shaders_hash: 'Shaders',
        renderer: 'Renderer',
    };
    const rows = [['Path', code(item.reference), code(item.candidate)]];
    for (const [key, title] of Object.entries(titles)) {
        const a = item.reference_origin[key], b = item.candidate_origin[key];
        if (a || b)
            rows.push(Object.assign([title, code(a), code(b)], {name: a === b ? '' : 'differs'}));
    }
    return table_section('Made by', 'origins', ['', 'Reference', 'Candidate'], rows);
}

function picture_section(frame) {
    const size = (width, height) => width ? `${width} × ${height}` : '–';
    const rows = [
        ['Size, reference', size(frame.width, frame.height)],
        ['Size, candidate', size(frame.candidate_width, frame.candidate_height)],
    ];
    if (frame.status === 'compared') {
        rows.push(['Differing pixels', number(frame.differing_pixels)],
                  ['Largest difference', `${frame.largest_difference} levels of 255`],
                  ['Mean difference', `${number(frame.mean_difference)} levels`]);
    }
    return table_section('Picture', 'picture', [], rows);
}

function sequence_sections(item) {
    const lines = [];
    const some = frames => frames.slice(0, 40).join(', ') + (frames.length > 40 ? ', ...' : '');
    if (item.shift !== null)
        lines.push(`Frame i + ${item.shift} of the candidate is frame i of the reference.`);
    if (item.missing_frames.length)
        lines.push(`Only the reference has ${count_of(item.missing_frames.length, 'frame')}: ` +
                   some(item.missing_frames));
    if (item.extra_frames.length)
        lines.push(`Only the candidate has ${count_of(item.extra_frames.length, 'frame')}: ` +
                   some(item.extra_frames));
    return lines.length ? [make('section', {}, make('h3', {}, 'Sequence'), ...lines.map(line => make('p', {}, line)))] :
                          [];
}

// Largest value / limit of the last runs, oldest first, logarithmic.
function history_sections(item) {
    if (!item.history.length)
        return [];
    const bar = run => make('span', {
        class: 'fill ' + (run.is_failed ? 'changed' : 'identical'),
        style: `height:${clamp(28 * Math.log2(1 + run.curve), 2, 60)}px`,
        title: `${run.time}: ${number(run.curve)} of the limit, ${run.is_failed ? 'failed' : 'passed'}`
    });
    const failed = item.history.filter(run => run.is_failed).length;
    const text = `${failed} of the last ${item.history.length} failed` +
        (item.is_flaky ? '; flaky: the verdict changes to and fro' : '');
    return [make('section', {id: 'history'}, make('h3', {}, 'Last runs'),
                 make('div', {class: 'runs'}, ...item.history.map(bar)), make('p', {class: 'muted'}, text))];
}

function show_facts() {
    const item = the_case(), frame = the_frame(), sections = [];
    if (frame && frame.bodies.length) {
        const titles = ['Body', 'What', 'In the picture', 'In space', 'Where'];
        sections.push(table_section('Bodies', 'bodies', titles, frame.bodies.map(body_row)));
    }
    if (frame && frame.gates.length) {
        const titles = ['Gate', 'Value', 'Limit', '', 'What was measured'];
        sections.push(table_section('Gates', 'gates', titles, frame.gates.map(gate_row)));
    }
    if (frame && frame.clusters.length) {
        const titles = ['Where', 'What', 'Pixels', 'Largest', 'Shift'];
        sections.push(table_section('What differs', 'clusters', titles, frame.clusters.map(cluster_row)));
    }
    if (frame)
        sections.push(picture_section(frame));
    by_id('facts').replaceChildren(...sections, ...sequence_sections(item), ...history_sections(item), origins_section(item));
}
