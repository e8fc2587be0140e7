// SPDX-License-Identifier: MIT
/* What a view renders, without a browser: its templates are read, and nothing is drawn. */

/* [the text before it, value] of each value of a template, and of the templates in it. */
export function valuesOf(template) {
    if (Array.isArray(template)) return template.flatMap(valuesOf);
    if (template?._$litDirective$) return valuesOfRepeat(template);
    return (template?.strings ? template.values : []).flatMap((value, index) => [[template.strings[index], value], ...valuesOf(value)]);
}

/* repeat() has its items, and a template of each; live() has no items. */
function valuesOfRepeat({ values: [items, , make] }) {
    return make ? items.flatMap((item) => valuesOf(make(item))) : [];
}

/* The first value of an attribute or listener, as "@input". */
export function attributeOf(template, name) {
    return valuesOf(template).find(([before]) => before.endsWith(`${name}=`))?.[1];
}
