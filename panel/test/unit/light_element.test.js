// SPDX-License-Identifier: MIT
/* LightElement without a browser: when it renders, and what it tells of it. */

import "../support/elements.js";
import assert from "node:assert/strict";
import test from "node:test";
import { settle } from "../support/fake_clock.js";

globalThis.document = { createComment: () => ({}), createTreeWalker: () => ({}) }; // as much as Lit asks for; before its import
const { LightElement } = await import("../../src/views/light_element.js");

/* An element that keeps the names of the changed properties of each update, and draws nothing. */
class Base extends LightElement {
    static properties = ["one"];

    updates = [];
    insertBefore = (node) => node; // of HTMLElement

    updated(changed) {
        this.updates.push([...changed].sort().join(" "));
    }
}

class Derived extends Base {
    static properties = ["two"];

    updated(changed) {
        super.updated(changed);
        this.onUpdated?.();
    }
}

/* An element whose first update is done. */
async function connected() {
    const element = new Derived();

    element.connectedCallback();
    await element.updateComplete;
    element.updates = [];
    return element;
}

test("LightElement: nothing is rendered before the element is in the document", async () => {
    const element = new Derived();

    element.one = 1;
    await settle();
    assert.deepEqual(element.updates, []);
    element.connectedCallback();
    await element.updateComplete;
    assert.deepEqual(element.updates, ["one"]);
});

test("LightElement: changes of one turn are one update, with inherited properties", async () => {
    const element = await connected();

    Object.assign(element, { one: 1, two: 2 });
    element.one = 3;
    element.requestUpdate();
    await element.updateComplete;
    assert.deepEqual(element.updates, ["one two"]);
    assert.deepEqual([element.one, element.two], [3, 2]);
});

test("LightElement: the same value again asks for no update", async () => {
    const element = await connected();

    element.one = NaN;
    await element.updateComplete;
    element.one = NaN;
    await settle();
    assert.deepEqual(element.updates, ["one"]);
});

test("LightElement: properties of a class are not those of its base", async () => {
    class Plain extends Base {}
    const element = new Plain();

    element.connectedCallback();
    await element.updateComplete;
    element.updates = [];
    element.two = 2;
    await settle();
    assert.deepEqual(element.updates, []);
});

test("LightElement: a change in updated() is another update", async () => {
    const element = await connected();

    element.onUpdated = () => (element.two = 2);
    element.one = 1;
    await settle();
    assert.deepEqual(element.updates, ["one", "two"]);
});

test("LightElement: firstUpdated() once; shouldUpdate() false renders nothing", async () => {
    const element = new Derived();
    const calls = [];

    element.firstUpdated = () => calls.push("first");
    element.render = () => void calls.push("render");
    element.connectedCallback();
    await element.updateComplete;
    element.shouldUpdate = () => false;
    element.one = 1;
    await element.updateComplete;
    assert.deepEqual(calls, ["render", "first"]);
    assert.deepEqual(element.updates, [""]);
});

test("LightElement: an update that fails is reported, and does not stop the next one", async (t) => {
    const element = await connected();
    const reported = [];

    t.mock.method(Promise, "reject", (error) => reported.push(error.message)); // the browser reports such a promise
    element.render = () => {
        throw new Error("broken");
    };
    element.one = 1;
    await assert.rejects(element.updateComplete, /broken/);
    delete element.render;
    element.two = 2;
    await element.updateComplete;
    assert.deepEqual(element.updates, ["two"]);
    assert.deepEqual(reported, ["broken"]);
});
