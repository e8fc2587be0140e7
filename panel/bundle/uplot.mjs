// SPDX-License-Identifier: MIT
/* uPlot without the features that src/views/plot.js does not use: saves 11.8 KB gzipped.
 *
 * Each fact below holds with the options that plot.js gives. It replaces an expression of uPlot.esm.js by the value
 * that the expression then always has; the minifier removes the code that this makes unreachable.
 * panel/test/browser/uplot.test.js compares every pixel with the whole uPlot. A new option in plot.js may make a fact false: remove this fact. */

/* A block of uPlot from `begin` to its end at the same indentation. */
const block = (begin, end = "\\}") => new RegExp(`^(\\t*)${begin}[^]*?^\\1${end}.*$`, "gm");
const line = (begin) => new RegExp(`^\\t*${begin}.*$`, "gm");
const constant = (name) => new RegExp(`(?:const|let|var) ${name}\\s+=.*`, "g");
/* A variable that always has this value: the declaration goes, and the value stands where the variable was read. */
const always = (name, value) => [
    [constant(name), ""],
    [new RegExp(`(?<![.\\w])${name}\\b(?!\\s*:)`, "g"), value],
];

/* Pairs: what uPlot has, what stands in its place ("": nothing). */
const FACTS = {
    "It runs in a browser of today.": [
        [constant("domEnv"), "const domEnv = true;"],
        [constant("microTask"), "const microTask = queueMicrotask;"],
    ],
    "plot.js uses only new uPlot(), setData, setSize, setSelect, posToVal, destroy, select and cursor.": [
        [/^uPlot\.assign = assign;[^]*?(?=^export)/gm, ""],
        [line("on\\(dppxchange, win, \\(\\) => \\{ uPlot"), ""],
        [/^\tself\.(?:addSeries|delSeries|batch|setSeries|addBand|setBand|delBand|setScale|valToIdx|posToIdx|setLegend) = .*$/gm, ""],
        [block("self\\.(?:redraw|setCursor) = "), ""],
        [block("self\\.valToPos = \\(", "\\);"), ""],
        [block("Object\\.defineProperty\\(self, 'rect'"), ""],
        [/self\.(?:root|ctx|under|over|bands|padding|_padding|focus)\s*= /g, ""],
        [line("self\\.status = "), ""],
        [/^\t*if \(opts\.id != null\)\n.*$/gm, ""],
        [line("addClass\\(root, opts\\.class\\)"), ""],
        [block("if \\(opts\\.title\\)"), ""],
        [block("\\(opts\\.plugins \\|\\| \\[\\]\\)\\.forEach"), ""],
        [/if \(then\) \{[^]*?\n\telse\n\t\t_init\(\);/g, "then.appendChild(root); _init();"], // plot.js passes an element
        [/opts\.drawOrder \|\| /g, ""],
        [/opts\.padding \|\| /g, ""],
    ],
    "Hooks: setSelect and setCursor.": [
        [/^\t*fire\("(?!setSelect|setCursor).*\);$/gm, ""],
        [line("_fire !== false && fire\\(\"set(?:Legend|Series)"), ""],
        [block("function flushHooks"), ""],
        [block("function batch"), ""],
        ...always("deferHooks", "false"),
    ],
    "Mode 1: all series have the same times, which stand upright and go to the right.": [
        [/mode: ifNull\(opts\.mode, 1\),/g, ""],
        ...always("mode", "1"),
        [/scaleX\.ori == 0/g, "true"],
        [/scaleX\.ori == 1/g, "false"],
        [/sx\.ori == 0/g, "true"],
        [/const dir = scaleX\.dir \* .*/g, "const dir = 1;"],
        [/(?:scale|sc)\.dir == -1/g, "false"],
        [constant("xScaleKey"), 'const xScaleKey = "x";'],
        [block("const facet ="), ""],
        [block("const xySeriesOpts ="), "const xySeriesOpts = {};"],
    ],
    "Scales are linear numbers, not dates, with a function `range` each.": [
        ...always("isTime", "false"),
        [/scaleX\.time\b/g, "false"],
        [/\b(?:sc|scale|wsc)\.distr == 1\b/g, "true"],
        [/\b(?:sc|scale|wsc)\.distr\s+(?:==|>=)\s+(?:[234]|100)\b/g, "false"],
        [/(?<![.\w])distr == (?:[34]|100)\b/g, "false"],
        ...always("xScaleDistr", "1"),
        [/^const months = \[[^]*?(?=^\/\/export const series)/gm, ""], // names of months, formats of dates
        [/^const NL = [^]*?(?=^\/\/ base 2)/gm, ""], // steps of times
        [line("const wholeIncrs"), ""],
        [line("const _(?:tzDate|fmtDate|timeAxisSplits|timeAxisVals|timeSeriesVal) "), ""],
        [/\b(?:sc|wsc)\.from == null/g, "true"],
        [/\b(?:sc|wsc)\.from != null/g, "false"],
        [/if \(scaleOpts\.from != null\) \{[^]*?^\t\t\t\}\n\t\t\telse /gm, ""],
        [block("if \\(scaleKey != xScaleKey \\|\\| "), ""],
        [/sc\.range = fnOrSelf\([^]*?\)\);/g, "sc.range = rn;"],
        [line("sc\\.clamp = "), ""],
        ...always("rangeIsArr", "false"),
        [/\[_min, _max\] = rangeNum\(.*/g, ";"], // the function `range` of the scale x does not use them
        [/\/\/ explicitly-set initial scales\n[^]*?^\t\}$/gm, ""],
        [/let getEdgeIdxs = log .*/g, "const getEdgeIdxs = nonNullIdxs;"],
        [/let predicate = log .*/g, "const predicate = notNullish;"],
    ],
    "There is no legend; points stand at the cursor, as with a legend that is live.": [
        ...always("showLegend", "false"),
        [/\blegend\.show\b/g, "false"],
        [/if \(legend\.live\) \{\s*const getMultiVals[^]*?\n\t\}/g, ""],
        ...always("multiValLegend", "false"),
        [/\blegend\.live\b/g, "true"],
        [/\tconst markers    = legend\.markers;\n\n\t\{[^]*?\n\t\}/g, ""],
        [block("const legendOpts ="), "const legendOpts = {};"],
        [line("legendTable\\?\\.remove"), ""],
        [line("s\\.(?:value|label) = "), ""],
        [/let sv = s\.value;/g, ""],
    ],
    "A vertical cursor, without lock, focus or a least distance; a drag selects times, and sets no scale.": [
        ...always("showCursor", "true"),
        [/if \(cursor\.x\)/g, "if (true)"],
        [/if \(cursor\.y\)/g, "if (false)"],
        [line("hCursor && elTrans"), ""],
        ...always("cursorOnePt", "false"),
        ...always("cursorFocus", "false"),
        [/\bcursor\._lock\b(?! =)/g, "false"],
        [/\bcursor\.lock\b/g, "false"],
        [/\bselect\.(?:show|over)\b/g, "true"],
        [/\bdrag\.setScale\b/g, "false"],
        [/dragX = dragY = drag\._x/g, "dragX = drag._x"],
        [line("dragY = (?:drag\\.y|sdrag\\._y)"), ""],
        [/drag\.x && rawDX >= drag\.dist/g, "true"],
        [/let uni = drag\.uni;[^]*?dragX = dragY = true;/g, ""],
        [block("if \\(dragH && dragV\\)"), ""],
        [line("dragV = drag[XY];"), ""],
        [/let dragH, dragV;/g, "let dragH;"],
        [/\bdragV\b/g, "false"],
        ...always("dragY", "false"),
        [/onMouse\(dblclick, over, dblClick\)/g, "onMouse(dblclick, over)"], // plot.js has its own handler
        [/cursor\.dataIdx == null/g, "true"],
        [line("let _?prox = "), ""],
        ...always("withProx", "false"),
        [/let bias = (?:hov|focus)\.bias.*/g, ""],
        [/(?<![.\w])bias\b(?!:)/g, "0"],
        [/getBBox = points\.bbox/g, "getBBox"],
        [/getBBox != null/g, "false"],
        [line("events\\.(?:mousedown|mouseup|dblclick) = "), ""], // other graphs follow movements only
        [block('events\\["setSeries"\\]'), ""],
        [block("function setSeries"), "function setSeries() {}"],
    ],
    "Series are lines, with gaps at null, without fill, bands, points or own transparency.": [
        [/\tconst bands   = [^]*?\n\t\}\);/g, ""],
        [block("function fillStroke"), ""],
        [/fillStroke\(si, /g, "strokeFill("],
        [/let \[ bandFillDir, bandClipDir \] = .*/g, ""],
        [/bandFillDir != 0/g, "false"],
        [/bandClipDir != 0/g, "false"],
        [/series\.fill != null/g, "false"],
        [/s\.paths \|\| linearPath \|\| retNull/g, "linearPath"],
        [line("s\\.fillTo = "), ""],
        ...always("alignGaps", "0"),
        [/!series\.spanGaps/g, "true"],
        [/series\.gaps\(u, seriesIdx, idx0, idx1, gaps\)/g, "gaps"],
        [/const rect = ori == 0 \? rectH : rectV;/g, "const rect = rectH;"],
        [constant("rectH"), "const rectH = (p, x, y, w, h) => p.rect(x, y, w, h);"],
        [line("const rectV"), "const rectV = 0;"],
        [line("const drawAccV"), "const drawAccV = 0;"],
        [constant("pointsPath"), ""],
        [line("paths: pointsPath"), ""],
        [/\{\n\t+let _gaps = s\._paths != null[^]*?\n\t{5}\}\n/g, ""],
        [/^\t\t\tpoints\.(?:filter|paths|show|pxAlign) .*/gm, ""],
        [line("show: seriesPointsShow"), ""],
        [constant("focus"), ""],
        ...always("shouldAlpha", "false"),
        [/ctxAlpha != (?:s\.alpha|_ctxAlpha)/g, "false"],
        [/strokePath instanceof Map/g, "false"],
        [/fillPath instanceof Map/g, "false"],
    ],
    "Lines stand at whole pixels.": [
        [line("s\\.pxAlign = "), ""],
        [/= pxRoundGen\((?:s\.)?pxAlign\)/g, "= round"],
        [/s\.pxAlign == 1/g, "true"],
        [block("function pxRoundGen"), ""],
        ...always("pxAlign", "1"),
    ],
    "Axes: numbers in one line with a grid; no label, ticks, border, turn or alignment. plot.js gives the font.": [
        [/axis\.label != null/g, "false"],
        [line("axis\\.(?:labelFont|rotate) "), ""],
        [/side == 2 \? axis\.rotate\(self, values, i, _space\) : 0/g, "0"],
        ...always("angle", "0"),
        [/\[axis\.font, axis\.labelFont\]/g, "[axis.font]"],
        [line("labelFont,"), ""],
        [/^const font  .*/gm, "const font = 0;"],
        [/\b(?:ticks|border)\.show\b/g, "false"],
        [line("axis\\.(?:ticks|border)\\.stroke "), ""],
        [block("const ticks = "), "const ticks = {};"],
        [block("const border = "), "const border = {};"],
        [/axis\.alignTo == 2/g, "false"],
        [/axis\.align == [12]/g, "false"],
        [/let _parts = .*/g, "const _parts = [val];"],
        [block("if \\(isArr\\(axis\\.incrs\\)\\)"), ""],
        [/isArr\(av\) && !isArr\(av\[0\]\) \? fnOrSelf\(av\) :/g, ""],
        [/fnOrSelf\(axis\.incrs .*/g, "fnOrSelf(numIncrs);"],
        [/fnOrSelf\(axis\.splits .*/g, "numAxisSplits;"],
        [/fnOrSelf\(axis\.filter .*/g, "retArg1;"],
    ],
};

/* The text of uPlot.esm.js with the facts. Throws if uPlot has changed: then look at each fact again. */
export function withFacts(text) {
    for (const [fact, pairs] of Object.entries(FACTS))
        for (const [pattern, value] of pairs) {
            const known = text.replace(pattern, () => value);

            if (known === text) throw new Error(`uPlot has no ${pattern} (${fact})`);
            text = known;
        }
    return text;
}

/* Rules of uPlot.min.css for what is never drawn. */
const UNUSED_RULES = /[^{}]*\.u-(?:title|legend|inline|series|vt \.u-cursor-x)\b[^{}]*\{[^}]*\}/g;

/* The text of uPlot.min.css without the rules of legend and title, and without a font: no element of uPlot has text then. */
export const withoutLegend = (text) => text.replace(UNUSED_RULES, "").replace(/font-family:[^;]*;/, "");
