// Names what a glance at the page would find wrong; evaluated by layout.py. `shared`: pixels that two texts may share.
(shared) => {
    const faults = [];
    const root = document.documentElement;
    if (root.scrollWidth > innerWidth) {
        const wide = [...document.querySelectorAll("main *")].filter((one) => one.getBoundingClientRect().right > innerWidth + 1);
        faults.push(`the page is ${root.scrollWidth} px wide, the window ${innerWidth}: ${wide.slice(0, 3).map((one) => one.outerHTML.slice(0, 80))}`);
    }

    const open = document.querySelector("dialog[open]");
    const scene = open ?? document.body;
    const seen = (node) => node.checkVisibility({ opacityProperty: true, visibilityProperty: true });
    const floats = (node) => {
        for (let one = node; one && one !== scene; one = one.parentElement) {
            if (["fixed", "sticky"].includes(getComputedStyle(one).position) || one.matches(".visually-hidden, .skip, .modebar")) return true;
        }
        return false;
    };
    const clipped = (box, node) => {
        let { left, top, right, bottom } = box;
        for (let one = node; one && one !== document.body; one = one.parentElement) {
            if (getComputedStyle(one).overflow === "visible") continue;
            const edge = one.getBoundingClientRect();
            [left, top] = [Math.max(left, edge.left), Math.max(top, edge.top)];
            [right, bottom] = [Math.min(right, edge.right), Math.min(bottom, edge.bottom)];
        }
        return { left, top, right, bottom };
    };
    const boxes = [];
    const add = (node, box, text) => {
        const { left, top, right, bottom } = clipped(box, node);
        if (right - left > 1 && bottom - top > 1) boxes.push({ node, left, top, right, bottom, text });
    };
    const walker = document.createTreeWalker(scene, NodeFilter.SHOW_TEXT);
    const range = document.createRange();
    for (let text = walker.nextNode(); text; text = walker.nextNode()) {
        const node = text.parentElement;
        if (!text.data.trim() || node.closest("script, style, title, option, textarea") || !seen(node) || floats(node)) continue;
        range.selectNodeContents(text);
        for (const box of range.getClientRects()) add(node, box, text.data.trim());
    }
    for (const node of scene.querySelectorAll("input, select, textarea, meter, progress")) {
        if (seen(node) && !floats(node)) add(node, node.getBoundingClientRect(), `<${node.localName} ${node.getAttribute("aria-label") ?? node.id}>`);
    }
    boxes.sort((a, b) => a.top - b.top);
    for (let i = 0; i < boxes.length; i++) {
        for (let j = i + 1; j < boxes.length && boxes[j].top < boxes[i].bottom - shared; j++) {
            const [a, b] = [boxes[i], boxes[j]];
            if (a.node === b.node || a.node.contains(b.node) && !a.text || Math.min(a.right, b.right) - Math.max(a.left, b.left) <= shared) continue;
            if (Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) <= shared) continue;
            faults.push(`“${a.text.slice(0, 40)}” and “${b.text.slice(0, 40)}” overlap at ${Math.round(b.left)}, ${Math.round(b.top + scrollY)}`);
        }
    }

    for (const frame of scene.querySelectorAll(".plot")) {
        if (!seen(frame)) continue;
        const label = frame.getAttribute("aria-label");
        const drawn = frame.querySelector(".main-svg")?.getBoundingClientRect();
        if (!drawn || drawn.width < 100 || drawn.height < 100) faults.push(`the plot “${label}” is not drawn`);
        else if (!frame.data.some((trace) => (trace.dimensions?.[0]?.values ?? trace.x ?? trace.y ?? trace.z)?.length)) faults.push(`the plot “${label}” is empty`);
        else if (!frame.layout.xaxis.ticktext && !frame.querySelector(".xtitle, .ytitle, .g-xtitle text, .g-ytitle text")) faults.push(`the axes of the plot “${label}” have no title`);
        const edge = frame.getBoundingClientRect();
        for (const text of frame.querySelectorAll(".g-xtitle text, .xtitle, .legendtext")) {
            const { left, right } = text.getBoundingClientRect();
            if (left < edge.left - 1 || right > edge.right + 1) faults.push(`“${text.textContent}” is cut off in the plot “${label}”`);
        }
    }
    for (const canvas of scene.querySelectorAll("canvas")) {
        if (!seen(canvas) || canvas.clientWidth < 20) continue;
        const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
        copy.drawImage(canvas, 0, 0);
        const pixels = new Uint32Array(copy.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
        if (canvas.clientWidth > 60 && pixels.every((pixel) => pixel === pixels[0])) faults.push(`the canvas “${canvas.getAttribute("aria-label") ?? canvas.className}” is of one colour`);
    }
    return faults;
}
