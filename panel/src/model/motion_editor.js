// SPDX-License-Identifier: MIT
/* Poses and sequences of the page: teaching, editing, what is chosen and shown. Each action that can fail is run by
 * the session: a failure is a notice. Changes are told by the session's event `change`. */

import { texts } from "../texts/texts.js";
import { MotionError, Motions, keywordsOf } from "./motions.js";
import { lastPositions, pathOfSequence, stepsTooFast } from "./path.js";
import { DEGREES_MAX, rawOfDegrees } from "./units.js";

const ERROR_TORQUE_OFF = 84;

export class MotionEditor {
    /* `ask(question, yes)` resolves with true if the user presses the button `yes`. */
    constructor(session, ask) {
        this.session = session;
        this.ask = ask;
        this.keywords = keywordsOf(session.tables);
        this.motions = new Motions({ keywords: this.keywords });
        this.unchosen = new Set(); // IDs that are not chosen
        this.pose = ""; // that is shown
        this.sequence = "";
        this.step = 0;
        this.times = 1;
        this.isLoop = false;
        this.version = 0; // counts changes of what the charts show
    }

    attempt(call, input) {
        return this.session.attempt(call, input);
    }

    changed() {
        this.version++;
        this.session.dispatchEvent(new Event("change"));
    }

    /* Edits poses and sequences; a rule that is broken is a notice. */
    edit(call) {
        return this.attempt(async () => {
            const result = call(this.motions);

            this.forgetUndo();
            return result;
        }, "edit").finally(() => this.changed());
    }

    /* As edit(). The notice that `what` is deleted offers Undo until the next edit. */
    #remove(what, call) {
        const { motions, pose, sequence, step } = this;
        const { isChanged } = motions;
        const [poses, sequences] = [new Map(motions.poses), new Map(motions.sequences)];
        const undo = () => {
            // What was stored or saved since the deletion lacks what comes back.
            Object.assign(motions, { poses, sequences, isChanged: isChanged || !motions.isChanged });
            Object.assign(this, { pose, sequence, step });
            this.forgetUndo();
            this.changed();
        };

        return this.edit((edited) => {
            call(edited);
            return true;
        }).then((isDone) => isDone && this.session.notify({ code: "motion-deleted", detail: what, undo }));
    }

    forgetUndo() {
        this.session.withdraw(["motion-deleted"]);
    }

    /* ---- servos ---- */

    get ids() {
        return this.session.robot?.ids ?? [];
    }

    get chosen() {
        return this.ids.filter((id) => !this.unchosen.has(id));
    }

    choose(id, isChosen) {
        if (isChosen) this.unchosen.delete(id);
        else this.unchosen.add(id);
        this.changed();
    }

    chooseAll(isChosen) {
        this.unchosen = new Set(isChosen ? [] : this.ids);
        this.changed();
    }

    /* Torque of the chosen servos. A servo that has torque keeps its goal. A servo that fails is told, the
     * others go on; a stop ends it. */
    setTorque(isOn) {
        return this.attempt(async () => {
            this.#checkChosen();
            await this.session.robot.setTorqueAll(isOn, (error) => this.session.notify(error), { ids: this.chosen, keepsGoals: true });
            if (isOn) this.session.withdraw([ERROR_TORQUE_OFF]);
        });
    }

    #checkChosen() {
        if (!this.session.isConnected) throw new MotionError("closed");
        if (!this.chosen.length) throw new MotionError("motion-none-chosen");
    }

    /* Where the chosen servos are. Throws MotionError if one of them does not answer. */
    present() {
        const { robot, clock } = this.session;

        this.#checkChosen();
        const servos = this.chosen.map((id) => robot.servos.get(id));
        const silent = servos.filter((servo) => servo.presence !== "online" || servo.isOld(clock.now()));

        if (silent.length) throw new MotionError("motion-offline", { ids: silent.map(({ id }) => id) });
        return new Map(servos.map(({ id, raw }) => [id, raw.position]));
    }

    /* ---- poses ---- */

    /* Keeps where the chosen servos are, as a new pose. */
    capture(name) {
        return this.edit((motions) => {
            if (motions.poses.has(name)) throw new MotionError("motion-twice", { detail: name });
            motions.setPose(name, this.present());
            this.pose = name;
            return true;
        });
    }

    /* Teaches the pose that is shown again. Servos that are not chosen keep their angles. */
    recapture() {
        return this.edit((motions) => motions.setPose(this.pose, [...motions.poses.get(this.pose), ...this.present()]));
    }

    removeJoint(id) {
        const { pose } = this;

        return this.#remove(`${texts.motion.pose} ${pose}, servo ${id}`, (motions) => motions.removeJoint(pose, id));
    }

    setAngle(id, degrees) {
        return this.edit((motions) => {
            if (!(degrees >= 0 && degrees <= DEGREES_MAX)) throw new MotionError("motion-angle", { detail: `servo ${id}` });
            motions.setAngle(this.pose, id, rawOfDegrees(degrees));
        });
    }

    renamePose(name) {
        return this.edit((motions) => {
            motions.renamePose(this.pose, name);
            this.pose = name;
        });
    }

    deletePose(name) {
        return this.#remove(`${texts.motion.pose} ${name}`, (motions) => {
            motions.deletePose(name);
            if (this.pose === name) this.pose = "";
        });
    }

    showPose(name) {
        this.pose = this.pose === name ? "" : name;
        this.changed();
    }

    /* ---- sequence ---- */

    get steps() {
        return this.motions.sequences.get(this.sequence) ?? [];
    }

    /* Times and Loop belong to the sequence that is shown: another one begins with 1 and without. */
    showSequence(name) {
        Object.assign(this, { sequence: name, step: 0, times: 1, isLoop: false });
        this.changed();
    }

    newSequence() {
        return this.edit((motions) => {
            const name = motions.freeName("seq", motions.sequences);

            motions.setSequence(name, []);
            this.showSequence(name);
        });
    }

    renameSequence(name) {
        return this.edit((motions) => {
            motions.renameSequence(this.sequence, name);
            this.sequence = name;
        });
    }

    deleteSequence() {
        return this.#remove(`${texts.motion.sequence} ${this.sequence}`, (motions) => {
            motions.deleteSequence(this.sequence);
            if (!motions.poses.has(this.pose)) this.pose = "";
            this.showSequence([...motions.sequences.keys()][0] ?? "");
        });
    }

    /* Adds a step to the pose that follows the last step's pose in the list; behind the last pose, to the first
     * one. Begins a sequence if there is none. */
    async addStep() {
        if (!this.sequence) await this.newSequence();
        return this.edit((motions) => {
            const names = [...motions.poses.keys()];

            if (!names.length) throw new MotionError("motion-empty");
            motions.addStep(this.sequence, { pose: names[(names.indexOf(this.steps.at(-1)?.pose) + 1) % names.length] });
            this.step = this.steps.length - 1;
        });
    }

    changeStep(index, change) {
        return this.edit((motions) => motions.changeStep(this.sequence, index, change));
    }

    moveStep(index, by) {
        return this.edit((motions) => {
            if (motions.moveStep(this.sequence, index, by)) this.step = index + by;
        });
    }

    removeStep(index) {
        return this.#remove(`${texts.motion.step} ${index + 1}`, (motions) => {
            motions.removeStep(this.sequence, index);
            this.step = Math.max(0, Math.min(this.step, this.steps.length - 1));
        });
    }

    showStep(index) {
        this.step = index;
        this.pose = this.steps[index]?.pose ?? this.pose;
        this.changed();
    }

    setLoop(isLoop) {
        this.isLoop = isLoop;
        this.changed();
    }

    /* The path of the sequence: from its last pose on if it loops, else from its first one. */
    get path() {
        return pathOfSequence(this.steps, this.motions.poses, this.#startOfLoop());
    }

    get stepsTooFast() {
        return stepsTooFast(this.steps, this.motions.poses, this.#startOfLoop());
    }

    #startOfLoop() {
        if (!this.isLoop || !this.steps.length) return new Map();
        return lastPositions(this.steps, this.motions.poses);
    }
}
