// Light or dark: as the system says, until the button says otherwise.
(() => {
    const system_dark = matchMedia('(prefers-color-scheme: dark)');
    const root = document.documentElement;
    let chosen = null;
    const show = () => {
        root.dataset.theme = chosen || (system_dark.matches ? 'dark' : 'light');
    };
    system_dark.addEventListener('change', show);
    document.addEventListener('DOMContentLoaded', () => {
        document.getElementById('theme').addEventListener('click', () => {
            chosen = root.dataset.theme === 'dark' ? 'light' : 'dark';
            show();
        });
    });
    show();
})();
