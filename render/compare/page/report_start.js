// ---- keyboard
const has_panes = () => state.case >= 0 && !by_id('viewer').hidden;
const is_sequence = () => state.case >= 0 && the_case().is_sequence;
const jump_to = key => {
    if (is_sequence() && the_case()[key] !== null)
        go_to_frame(index_at(the_case(), the_case()[key]));
};
function move_mark(dx, dy) {
    if (!has_panes())
        return;
    const {width, height} = pane_size(), middle = pixel_at({x: width / 2, y: height / 2});
    const from = mark || {x: middle.x - dx, y: middle.y - dy}, size = size_of(the_frame());
    set_mark({x: clamp(from.x + dx, 0, size.width - 1), y: clamp(from.y + dy, 0, size.height - 1)});
}
function hold_or_flip() {
    if (!has_panes())
        return;
    if (state.mode !== 'blink')
        set_mode('blink');
    if (state.mode !== 'blink')
        return;
    clearInterval(blinking);
    blinking = 0;
    flip();
}
const step_frame = by => {
    if (is_sequence())
        go_to_frame(state.frame + by);
};
const choose_mode = name => {
    if (has_panes() && !by_id('modes').querySelector(`[data-mode=${name}]`).disabled)
        set_mode(name);
};
const keys = [
    ['j', 'Next case', () => step_case(1)],
    ['k', 'Case before', () => step_case(-1)],
    ['/', 'Filter by name', () => by_id('search').focus()],
    ['ArrowRight', 'Next frame', () => step_frame(1)],
    ['ArrowLeft', 'Frame before', () => step_frame(-1)],
    ['f', 'First bad frame', () => jump_to('first_bad_frame')],
    ['w', 'Worst frame', () => jump_to('worst_frame')],
    ...modes.map(([name, label, key]) => [key.toLowerCase(), label, () => choose_mode(name)]),
    [' ', 'Hold the blink; other picture', hold_or_flip],
    ['+', 'Larger', () => has_panes() && zoom('in')],
    ['-', 'Smaller', () => has_panes() && zoom('out')],
    ['0', 'Whole picture', () => has_panes() && zoom('fit')],
    ['1', 'One to one', () => has_panes() && zoom('one')],
    ['o', 'Outlines on or off', () => by_id('outlines').click()],
    ['t', 'Light or dark', () => by_id('theme').click()],
    ['?', 'This list', () => by_id('help').showModal()],
    ['Escape', 'Back to the list', () => close_case()],
];
const key_names = {' ': 'Space', ArrowRight: '→', ArrowLeft: '←', Escape: 'Esc'};
const shifted_arrows = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};

function key_down(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || by_id('help').open)
        return;
    if (is_typing()) {
        if (event.key === 'Escape' || event.key === 'Enter')
            document.activeElement.blur();
        return;
    }
    if (document.activeElement === by_id('video'))
        return;
    const focused = document.activeElement;
    if (event.key === ' ' && focused.tagName === 'BUTTON')
        return;
    if (focused.classList.contains('divider') && !event.shiftKey && event.key.startsWith('Arrow')) {
        const step = {ArrowRight: 0.02, ArrowLeft: -0.02}[event.key] || 0;
        state.split = clamp(state.split + step, 0, 1);
        place_divider();
        event.preventDefault();
        return;
    }
    if (event.shiftKey && shifted_arrows[event.key]) {
        move_mark(...shifted_arrows[event.key]);
        event.preventDefault();
        return;
    }
    const pressed = event.key === '=' ? '+' : event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const found = keys.find(([key]) => key === pressed);
    if (found) {
        event.preventDefault();
        found[2]();
    }
}

// ---- start
function listen() {
    by_id('search').addEventListener('input', event => {
        state.text = event.target.value;
        filter_list();
    });
    by_id('help_button').addEventListener('click', () => by_id('help').showModal());
    by_id('back').addEventListener('click', close_case);
    by_id('case_before').addEventListener('click', () => step_case(-1));
    by_id('case_after').addEventListener('click', () => step_case(1));
    by_id('frame_before').addEventListener('click', () => go_to_frame(state.frame - 1));
    by_id('frame_after').addEventListener('click', () => go_to_frame(state.frame + 1));
    by_id('outlines').addEventListener('click', event => {
        state.outlines = !state.outlines;
        event.currentTarget.setAttribute('aria-pressed', state.outlines);
        if (has_panes())
            place_all();
    });
    for (const button of by_id('zooms').querySelectorAll('[data-zoom]'))
        button.addEventListener('click', () => zoom(button.dataset.zoom));
    const curve = by_id('curve');
    const pick = event => go_to_frame(curve.index_at(event.clientX - curve.getBoundingClientRect().left));
    curve.addEventListener('pointerdown', event => {
        curve.setPointerCapture(event.pointerId);
        pick(event);
    });
    curve.addEventListener('pointermove', event => {
        if (curve.hasPointerCapture(event.pointerId))
            pick(event);
    });
    const panes = by_id('panes');
    panes.addEventListener('pointerdown', pointer_down);
    panes.addEventListener('pointermove', pointer_move);
    panes.addEventListener('pointerup', pointer_up);
    panes.addEventListener('pointercancel', pointer_up);
    panes.addEventListener('wheel', wheel, {passive: false});
    panes.addEventListener('dblclick', event => {
        const pane = event.target.closest('.pane');
        if (pane) {
            const point = pane_point(event, pane);
            zoom_at(point.x, point.y, 2);
        }
    });
    by_id('video').addEventListener('timeupdate', film_moved);
    by_id('video').addEventListener('seeked', film_moved);
    by_id('speed').addEventListener('change', event => {
        by_id('video').playbackRate = Number(event.target.value);
    });
    document.addEventListener('keydown', key_down);
    // After a click with the mouse, Space is for the pictures and not for the button again.
    document.addEventListener('click', event => {
        const button = event.target.closest('button');
        if (button && event.detail > 0 && !button.closest('dialog')) {
            (button.closest('#viewer') ? panes : by_id('case')).focus({preventScroll: true});
        }
    });
    window.addEventListener('hashchange', open_hash);
    window.addEventListener('resize', () => {
        if (state.case < 0)
            return;
        if (is_sequence()) {
            draw_curve();
            show_frame_place();
        }
        if (has_panes())
            place_all();
    });
}

function open_hash() {
    const wanted = new URLSearchParams(location.hash.slice(1));
    const index = Number(wanted.get('case') ?? -1);
    if (index >= 0 && index < report.cases.length &&
        !(index === state.case && document.body.classList.contains('in_case')))
        open_case(index, wanted.has('frame') ? Number(wanted.get('frame')) : undefined);
    return index >= 0;
}

show_summary();
show_filter();
by_id('cases').replaceChildren(...sorted_cases.map(list_row));
filter_list();
const key_row = ([key, text]) => make('tr', {}, make('td', {}, make('kbd', {}, key)), make('td', {}, text));
by_id('keys').append(...keys.map(([key, text]) => key_row([key_names[key] || key.toUpperCase(), text])),
                     key_row(['Shift + arrows', 'Pixel beside the marked one']));
listen();
// A list of one case says nothing that the case does not.
const is_single = report.cases.length === 1;
document.body.classList.toggle('single', is_single);
if (is_single)
    by_id('cause').after(by_id('accept'));
show_accept();
if (!open_hash() && report.cases.length > 0 && (is_single || !matchMedia('(max-width: 820px)').matches))
    open_case(sorted_cases[0].index);
