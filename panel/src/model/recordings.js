// SPDX-License-Identifier: MIT
/* The recording of the page: how servos are led by hand, thinned out to steps, made into a sequence. `editor`
 * (model/motion_editor.js) has the chosen servos, and takes the sequence. */

import { pause } from "../wire/clock.js";
import { MotionError, STEPS_MAX, stepOf } from "./motions.js";
import { texts } from "../texts/texts.js";
import { stepsTooFast } from "./path.js";
import { Recorder, moving } from "./recording.js";
import { thin, thinTo } from "./thin.js";
import { DEGREES_MAX, degreesOf, rawOfDegrees } from "./units.js";

const FIRST_MS = 2000; // the way to the first pose of a recording
const TOLERANCE_DEGREES = 2;
const SHORT_MS = 100;

export class Recordings {
    #editor;

    constructor(editor) {
        this.#editor = editor;
        this.session = editor.session;
        this.recorder = null;
        this.latest = null; // Recording
        this.tolerance = TOLERANCE_DEGREES;
        this.thinned = null; // {points, error, tooFast}
        this.replay = null; // {samples, largest, mean, id}
        this.session.addEventListener("change", () => this.#follow());
    }

    /* True if a recording runs, or the latest one is neither a sequence nor saved. */
    get isUnsaved() {
        return this.isRecording || this.latest?.isKept === false;
    }

    get isRecording() {
        return Boolean(this.recorder?.isRecording);
    }

    begin() {
        return this.session.attempt(async () => {
            this.#editor.present();
            if (!(await this.#isLimp()) || this.isRecording) return; // the button was pressed twice
            this.recorder = new Recorder(this.session.robot, this.session.clock, { onEnd: (recording) => this.#takeRecording(recording) });
            this.recorder.start(this.#editor.chosen);
            this.#editor.changed();
        });
    }

    /* A servo that has torque cannot be led by hand. True: the chosen servos have none; if some had, the user was asked. */
    async #isLimp() {
        const editor = this.#editor;
        const held = () => editor.chosen.filter((id) => this.session.robot.servos.get(id).torque);

        if (!held().length) return true;
        if (await editor.ask(texts.motion.askTorqueOff(held()), texts.motion.torqueOffAndRecord)) await editor.setTorque(false);
        return !held().length;
    }

    end() {
        return this.session.attempt(async () => {
            if (!this.isRecording) return;
            const recording = this.recorder.end();

            if (recording.length < SHORT_MS) throw new MotionError("motion-short");
            this.#takeRecording(recording);
        });
    }

    #takeRecording(recording) {
        recording.samples = moving(recording.samples);
        this.latest = recording;
        this.replay = null;
        this.setTolerance(this.tolerance);
    }

    /* Thins the recording out to steps within `degrees`; NaN changes nothing. */
    setTolerance(degrees) {
        if (Number.isNaN(degrees)) return;
        this.tolerance = Math.min(Math.max(degrees, 0.1), DEGREES_MAX);
        this.#takeThinned(thin(this.latest.samples, rawOfDegrees(this.tolerance)));
    }

    /* As many steps as a sequence of the board may have, with the smallest error that the page finds. */
    async fit() {
        const { latest, thinned: before } = this;
        const thinned = await thinTo(latest.samples, STEPS_MAX, () => pause(this.session.clock, 0));

        if (this.latest !== latest || this.thinned !== before) return; // the user has gone on
        this.#takeThinned(thinned);
    }

    #takeThinned(thinned) {
        const { poses, steps } = this.#stepsOf(thinned.points, "r");

        this.thinned = { ...thinned, tooFast: stepsTooFast(steps.slice(1), poses, poses.get(steps[0].pose)) };
        this.#editor.changed();
    }

    /* True if the steps are further from the recording than the user has chosen. */
    get isCoarse() {
        return degreesOf(this.thinned.error) > this.tolerance + 0.05; // as it is shown
    }

    /* The points as poses and steps. Step 1 goes to the first point and stops. The last step stops. The steps between
     * pass their poses. */
    #stepsOf(points, name) {
        const nameOf = (index) => `${name}x${index + 1}`;
        const poses = new Map(points.map(({ raw }, index) => [nameOf(index), new Map(this.latest.ids.map((id, joint) => [id, raw[joint]]))]));
        const steps = points.map(({ t }, index) => {
            const isEnd = index === 0 || index === points.length - 1;

            return stepOf({ pose: nameOf(index), time: index ? t - points[index - 1].t : FIRST_MS, passes: !isEnd });
        });

        return { poses, steps };
    }

    toSequence() {
        return this.#editor.edit((motions) => {
            const { points } = this.thinned;
            const stems = [...motions.poses.keys()].map((pose) => pose.replace(/x\d+$/, ""));
            const name = motions.freeName("rec", new Set([...motions.sequences.keys(), ...stems]));

            if (points.length > STEPS_MAX) throw new MotionError("motion-steps", { detail: name, count: points.length });
            const { poses, steps } = this.#stepsOf(points, name);

            for (const [pose, positions] of poses) motions.setPose(pose, positions);
            motions.setSequence(name, steps);
            this.latest.isKept = true;
            this.#editor.showSequence(name);
        });
    }

    /* The recording as lines of comma-separated values, in degrees. It is saved. */
    exportCsv() {
        const { ids, samples } = this.latest;

        this.latest.isKept = true;
        const rows = samples.map(({ t, raw }) => [(t / 1000).toFixed(3), ...raw.map((value) => degreesOf(value).toFixed(2))].join(","));

        return [["time s", ...ids.map((id) => `servo ${id} deg`)].join(","), ...rows].join("\n") + "\n";
    }

    /* The connection is lost: what was recorded before is kept. */
    #follow() {
        if (!this.isRecording || this.session.isConnected) return;
        const recording = this.recorder.end(); // before the notice, which calls #follow() again

        this.session.notify({ code: "motion-record-cut" });
        if (recording.length >= SHORT_MS) this.#takeRecording(recording);
    }
}
