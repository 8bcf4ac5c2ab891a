// Steps of a walk with the Tab key through a page; evaluated by test_keyboard.py.
({
    /** Every element that a pointer can act on but the keyboard did not reach. */
    missed(reached) {
        const seen = (node) => node.checkVisibility({ opacityProperty: true, visibilityProperty: true });
        const done = new Set(reached.map((number) => window.walked[number]));
        const scene = document.querySelector("dialog[open]") ?? document.body;
        const controls = "a[href], button, input, select, textarea, summary, [tabindex='0'], [role=button], [role=slider]";
        const known = [...scene.querySelectorAll(controls)];
        const told = (node) => node.outerHTML.slice(0, 120);
        const lost = known.filter((node) => {
            if (!seen(node) || node.disabled || done.has(node)) return false;
            // Of radio buttons with one name one is reached, the others by the arrow keys.
            return !(node.type === "radio" && [...done].some((other) => other.type === "radio" && other.name === node.name));
        }).map(told);
        // What looks as if it could be clicked is a control, lies in one, holds one, or names one.
        const bare = [...scene.querySelectorAll("*")].filter((node) => seen(node) && getComputedStyle(node).cursor === "pointer"
            && !node.closest(`${controls}, label, .modebar, .legend`) && !node.querySelector(controls) && !(node instanceof SVGElement)
            && !(node.closest("tr")?.querySelector(controls))).map(told);
        return [...lost, ...bare];
    },
    /** Number of the element that has the focus, and whether the reader sees where that is. */
    focused() {
        window.walked ??= [];
        const node = document.activeElement;
        if (!node || node === document.body) return null;
        let number = window.walked.indexOf(node);
        if (number < 0) number = window.walked.push(node) - 1;
        const { outlineStyle, outlineWidth } = getComputedStyle(node);
        const named = node.labels?.[0] ?? node; // the label of a hidden input shows the focus for it
        const other = named === node ? null : getComputedStyle(named);
        const drawn = (style) => style && style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 1;
        const box = node.getBoundingClientRect();
        return [number, drawn({ outlineStyle, outlineWidth }) && (box.width > 2 || drawn(other)) || drawn(other), node.outerHTML.slice(0, 120)];
    },
})
