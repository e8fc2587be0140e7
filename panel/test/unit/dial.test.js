// SPDX-License-Identifier: MIT
/* Geometry of the position dial. */

import assert from "node:assert/strict";
import test from "node:test";
import { arcOf, degreesAt, degreesOfDrag, pointOf, rotationOf } from "../../src/model/dial.js";

test("point: 150 degrees is at the top, 0 at the lower right", () => {
    assert.ok(Math.abs(pointOf(150, 10).x) < 1e-9);
    assert.equal(pointOf(150, 10).y, -10);
    assert.ok(pointOf(0, 10).x > 0 && pointOf(0, 10).y > 0);
    assert.ok(pointOf(300, 10).x < 0 && pointOf(300, 10).y > 0);
});

test("degrees: what point() gives", () => {
    for (let degrees = 0; degrees <= 300; degrees += 7.5) {
        const { x, y } = pointOf(degrees, 40);

        assert.ok(Math.abs(degreesAt(x, y) - degrees) < 1e-9, `${degrees}`);
    }
});

test("degrees: a point in the gap is the nearer end", () => {
    assert.equal(degreesAt(1, 30), 0);
    assert.equal(degreesAt(-1, 30), 300);
});

test("drag: through the gap stays at its end", () => {
    assert.equal(degreesOfDrag(290, 1, 30), 300);
    assert.equal(degreesOfDrag(10, -1, 30), 0);
    assert.equal(degreesOfDrag(290, -1, 30), 300);
    assert.equal(degreesOfDrag(140, 0, -30), 150);
});

test("drawing: path from 0 to 300 degrees, rotation from the top", () => {
    assert.equal(arcOf(40), "M20.00 34.64A40 40 0 1 0 -20.00 34.64");
    assert.equal(rotationOf(150), "0.0");
    assert.equal(rotationOf(60), "90.0");
});
