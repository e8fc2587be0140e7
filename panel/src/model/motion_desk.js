// SPDX-License-Identifier: MIT
/* What the view Motion works on: poses and sequences of the page, a recording, what is chosen, what plays.
 * Each action that can fail is run by the session: a failure is a notice.
 *
 * Changes are told by the session's event `change`. */

import { linesOfSequence, linesOfPose, readMotions, textOfMotions } from "./motion_text.js";
import { MotionStore } from "./motion_store.js";
import { MotionError, Motions, STEPS_MAX, keywordsOf, stepOf } from "./motions.js";
import { pathOfPoints, pathOfSequence, tooFast } from "./path.js";
import { Player } from "./player.js";
import { Recorder, compare } from "./recording.js";
import { texts } from "../texts/texts.js";
import { errorOf, thin, thinTo } from "./thin.js";
import { DEGREES_MAX, degreesOf, rawOfDegrees } from "./units.js";

const FIRST_MS = 2000; // the way to the first pose of a recording
const TOLERANCE_DEGREES = 2;
const ERROR_NO_MOTION = 79; // the motion was ended
const UNDER_WAY = 2; // register MOTION_STATE
const SHORT_MS = 100;

export class MotionDesk {
    #loadedFrom = null; // the controller whose poses and sequences were read
    #shownOf = null; // the controller that was asked for them when the view was shown
    #motionState = 0;
    #isStopped = false; // the user has stopped the motion that is or was under way
    #robot = null;

    /* `ask(text)` resolves with true if the user says yes. */
    constructor(session, { ask } = {}) {
        this.session = session;
        this.ask = ask;
        this.keywords = keywordsOf(session.tables);
        this.motions = new Motions({ keywords: this.keywords });
        this.store = new MotionStore(session);
        this.player = new Player(session);
        this.recorder = null;
        this.left = new Set(); // IDs that are not chosen
        this.pose = ""; // that is shown
        this.sequence = "";
        this.step = 0;
        this.recording = null;
        this.tolerance = TOLERANCE_DEGREES;
        this.thinned = null; // {points, error, boardError}
        this.replay = null; // {samples, largest, mean, id}
        this.times = 1;
        this.isLoop = false;
        this.percent = 100;
        this.by = "board"; // or page
        this.task = ""; // storing, loading
        this.version = 0; // counts changes of what the charts show
        session.addEventListener("change", () => this.#follow());
    }

    #attempt(call) {
        return this.session.attempt(call);
    }

    #changed() {
        this.version++;
        this.session.dispatchEvent(new Event("change"));
    }

    /* Edits poses and sequences; a rule that is broken is a notice. */
    edit(call) {
        return this.#attempt(async () => {
            const result = call(this.motions);

            this.#forgetUndo();
            return result;
        }).finally(() => this.#changed());
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
            this.#forgetUndo();
            this.#changed();
        };

        return this.edit((edited) => {
            call(edited);
            return true;
        }).then((isDone) => isDone && this.session.notify({ code: "motion-deleted", detail: what, undo }));
    }

    #forgetUndo() {
        this.session.withdraw(["motion-deleted"]);
    }

    /* True if poses or sequences have changed since they were loaded, stored or saved, or if a recording runs or is
     * neither a sequence nor saved. */
    get hasUnsaved() {
        return this.isRecording || this.motions.isChanged || this.recording?.isKept === false;
    }

    /* ---- servos ---- */

    get ids() {
        return this.session.robot?.ids ?? [];
    }

    get chosen() {
        return this.ids.filter((id) => !this.left.has(id));
    }

    choose(id, isChosen) {
        if (isChosen) this.left.delete(id);
        else this.left.add(id);
        this.#changed();
    }

    chooseAll(isChosen) {
        this.left = new Set(isChosen ? [] : this.ids);
        this.#changed();
    }

    /* Torque of the chosen servos. A servo that has torque keeps its goal. A servo that fails is told, the
     * others go on; a stop ends it. */
    setTorque(isOn) {
        return this.#attempt(async () => {
            this.#checkChosen();
            for (const id of this.chosen) {
                if (isOn && this.session.robot.servos.get(id)?.torque === true) continue;
                try {
                    await this.session.robot.setTorque(id, isOn);
                } catch (error) {
                    if (["stopped", "closed", "silent", "inhibited"].includes(error.code)) throw error;
                    this.session.notify(error);
                }
            }
        });
    }

    #checkChosen() {
        if (!this.session.isConnected) throw new MotionError("motion-disconnected");
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

    /* Teaches the pose that is shown again. */
    recapture() {
        return this.edit((motions) => motions.setPose(this.pose, this.present()));
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
        this.#changed();
    }

    goTo(name) {
        return this.#attempt(() => this.player.goTo(this.motions.poses.get(name)));
    }

    /* ---- sequence ---- */

    get steps() {
        return this.motions.sequences.get(this.sequence) ?? [];
    }

    showSequence(name) {
        this.sequence = name;
        this.step = 0;
        this.#changed();
    }

    newSequence() {
        return this.edit((motions) => {
            const name = motions.freeName("seq", motions.sequences);

            motions.setSequence(name, []);
            this.sequence = name;
            this.step = 0;
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
            this.sequence = [...motions.sequences.keys()][0] ?? "";
        });
    }

    /* Adds a step to the pose that follows the last step's pose in the list; behind the last pose, to the first
     * one. Begins a sequence if there is none. */
    async addStep() {
        if (!this.sequence) await this.newSequence();
        return this.edit((motions) => {
            const names = [...motions.poses.keys()];

            if (!names.length) throw new MotionError("motion-no-poses");
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
        this.#changed();
    }

    /* The path of the sequence: from its last pose on if it loops, else from its first one. */
    get path() {
        return pathOfSequence(this.steps, this.motions.poses, this.#startOfLoop());
    }

    get tooFast() {
        return tooFast(this.steps, this.motions.poses, this.#startOfLoop());
    }

    #startOfLoop() {
        if (!this.isLoop || !this.steps.length) return new Map();
        return lastPositions(this.steps, this.motions.poses);
    }

    /* ---- recording ---- */

    get isRecording() {
        return Boolean(this.recorder?.isRecording);
    }

    record() {
        return this.#attempt(async () => {
            this.present();
            this.recorder = new Recorder(this.session.robot, this.session.clock, { onEnd: (recording) => this.#takeRecording(recording) });
            this.recorder.start(this.chosen);
            this.#changed();
        });
    }

    endRecording() {
        return this.#attempt(async () => {
            const recording = this.recorder.end();

            if (recording.length < SHORT_MS) throw new MotionError("motion-short");
            this.#takeRecording(recording);
        });
    }

    #takeRecording(recording) {
        this.recording = recording;
        this.replay = null;
        this.setTolerance(this.tolerance);
    }

    /* Thins the recording out to steps within `degrees`. */
    setTolerance(degrees) {
        this.tolerance = Math.min(Math.max(Number(degrees) || 0, 0.1), DEGREES_MAX);
        this.#takeThinned(thin(this.recording.samples, rawOfDegrees(this.tolerance)));
    }

    /* As many steps as a sequence of the board may have. */
    fit() {
        this.#takeThinned(thinTo(this.recording.samples, STEPS_MAX));
        this.tolerance = Math.ceil(degreesOf(this.thinned.error) * 10) / 10;
    }

    #takeThinned(thinned) {
        const { poses, steps } = this.#stepsOf(thinned.points, "r");
        const path = pathOfSequence(steps.slice(1), poses, poses.get(steps[0].pose));
        const points = this.recording.samples.map(({ t }) => ({ t: t - this.recording.samples[0].t, raw: path.at(t) }));

        this.thinned = { ...thinned, boardError: errorOf(this.recording.samples, points) };
        this.#changed();
    }

    /* The points as poses and steps: the first one is the way to the begin, the others pass their poses. */
    #stepsOf(points, name) {
        const nameOf = (index) => `${name}x${index + 1}`;
        const poses = new Map(points.map(({ raw }, index) => [nameOf(index), new Map(this.recording.ids.map((id, joint) => [id, raw[joint]]))]));
        const steps = points.map(({ t }, index) => {
            const isEnd = index === 0 || index === points.length - 1;

            return stepOf({ pose: nameOf(index), time: index ? t - points[index - 1].t : FIRST_MS, passes: !isEnd });
        });

        return { poses, steps };
    }

    toSequence() {
        return this.edit((motions) => {
            const { points } = this.thinned;
            const name = motions.freeName("rec", motions.sequences);

            if (points.length > STEPS_MAX) throw new MotionError("motion-steps", { detail: name, count: points.length });
            const { poses, steps } = this.#stepsOf(points, name);

            for (const [pose, positions] of poses) motions.setPose(pose, positions);
            motions.setSequence(name, steps);
            this.recording.isKept = true;
            this.sequence = name;
            this.step = 0;
        });
    }

    /* Plays the recording, or the points that it was thinned out to, from the page, and measures how well the
     * servos follow the recording. */
    playRecording({ isThinned = false } = {}) {
        const { recording, thinned } = this;
        const path = pathOfPoints(recording.ids, recording.samples);

        return this.#attempt(async () => {
            this.#usePercent();
            if (!(await this.player.play(isThinned ? pathOfPoints(recording.ids, thinned.points) : path))) return;
            const { samples } = this.player;
            const result = compare(path, samples);

            this.replay = { ...result, samples, id: recording.ids[result.joint] };
            this.#changed();
        });
    }

    /* The recording as lines of comma-separated values, in degrees. */
    get csv() {
        const { ids, samples } = this.recording;

        this.recording.isKept = true;
        const rows = samples.map(({ t, raw }) => [(t / 1000).toFixed(3), ...raw.map((value) => degreesOf(value).toFixed(2))].join(","));

        return [["time s", ...ids.map((id) => `servo ${id} deg`)].join(","), ...rows].join("\n") + "\n";
    }

    /* ---- play ---- */

    /* Who plays: the page if the board cannot. */
    get playedBy() {
        return this.store.canPlay ? this.by : "page";
    }

    get isBoardPlaying() {
        return Boolean(this.session.isConnected && this.session.robot.motion?.state);
    }

    get isPlaying() {
        return this.isBoardPlaying || this.player.isPlaying;
    }

    get isPaused() {
        return this.player.isPlaying ? this.player.isPaused : Boolean(this.session.robot?.motion?.paused);
    }

    play() {
        return this.#attempt(() => (this.playedBy === "board" ? this.#playByBoard() : this.#playByPage()));
    }

    async #playByBoard() {
        const { sequence, store, motions } = this;

        await this.#loadStored();
        if (!store.stored.sequences.has(sequence)) throw new MotionError("motion-not-stored", { detail: sequence });
        const { poses, sequences } = store.replaced(motions.partOf(sequence));

        if (poses.length || sequences.length) throw new MotionError("motion-differs", { detail: sequence });
        await store.play(sequence, { times: this.isLoop ? 0 : this.times, percent: this.percent });
    }

    async #playByPage() {
        const { steps } = this;
        const { poses } = this.motions;

        if (!steps.length) throw new MotionError("motion-no-steps", { detail: this.sequence });
        this.#usePercent();
        let start = new Map(this.ids.map((id) => [id, this.session.robot.servos.get(id).raw.position]));

        for (let left = this.isLoop ? Infinity : this.times; left > 0; left--) {
            if (!(await this.player.play(pathOfSequence(steps, poses, start)))) return;
            start = lastPositions(steps, poses);
        }
    }

    #usePercent() {
        this.player.percent = this.percent;
    }

    setLoop(isLoop) {
        this.isLoop = isLoop;
        this.#changed();
    }

    setPercent(percent) {
        this.percent = Math.min(Math.max(percent, 10), 200);
        this.player.percent = this.percent;
        if (this.isBoardPlaying) this.#attempt(() => this.store.override(this.percent));
        this.#changed();
    }

    pause() {
        if (!this.player.isPlaying) return this.#attempt(this.store.pause);
        this.player.isPaused = true;
        return this.#changed();
    }

    resume() {
        if (!this.player.isPlaying) return this.#attempt(this.store.resume);
        this.player.isPaused = false;
        return this.#changed();
    }

    end() {
        if (this.player.isPlaying) return this.player.end();
        return this.#attempt(this.store.end);
    }

    /* A new connection, and the end of a motion of the board. */
    #follow() {
        const { robot } = this.session;
        const motion = robot?.motion;

        if (this.isRecording && !this.session.isConnected) {
            const recording = this.recorder.end(); // before the notice, which calls #follow() again

            this.session.notify({ code: "motion-record-cut" });
            if (recording.length >= SHORT_MS) this.#takeRecording(recording);
        }
        if (robot !== this.#robot) {
            this.#robot = robot;
            this.#motionState = 0;
        }
        const before = this.#motionState;

        this.#motionState = motion?.state ?? 0;
        if (before !== UNDER_WAY) this.#isStopped = false;
        if (this.session.stopState === "stopping") this.#isStopped = true;
        if (this.#isStopped) return;
        if (before !== UNDER_WAY || this.#motionState || !motion?.error || motion.error === ERROR_NO_MOTION) return;
        const { text: message, remedy } = this.session.tables.errors[motion.error] ?? { text: "", remedy: "" };

        this.session.notify({ code: "motion-ended", number: motion.error, message, remedy });
    }

    /* ---- the board, files ---- */

    async #during(task, call) {
        this.task = task;
        this.#changed();
        try {
            return await call();
        } finally {
            this.task = "";
            this.#changed();
        }
    }

    /* Reads once for each connection what the board has. */
    async #loadStored() {
        const { controller } = this.session;

        if (this.#loadedFrom === controller) return;
        await this.store.load();
        this.#loadedFrom = controller;
    }

    /* The view is shown: reads what the board has; a page that has nothing takes it over. A load that fails is
     * tried again by play(), and not by each rendering of the view. */
    async show() {
        if (!this.store.canStore || this.task || this.#shownOf === this.session.controller) return;
        this.#shownOf = this.session.controller;
        await this.#during("loading", () =>
            this.#attempt(async () => {
                await this.#loadStored();
                if (this.motions.isEmpty) this.#takeMotions(this.store.stored);
            }),
        );
    }

    #takeMotions(motions) {
        this.motions = readMotions(textOfMotions(motions)).motions;
        this.motions.keywords = this.keywords;
        this.#forgetUndo();
        this.pose = "";
        this.showSequence([...this.motions.sequences.keys()][0] ?? "");
    }

    async load(askFirst) {
        if (this.motions.isChanged && !(await this.ask(askFirst))) return;
        await this.#during("loading", () =>
            this.#attempt(async () => {
                await this.store.load();
                this.#takeMotions(this.store.stored);
                if (this.store.gone.length) this.session.notify({ code: "motion-gone", names: this.store.gone });
                this.#tell("motion-loaded");
            }),
        );
    }

    async storeAll(textOfQuestion) {
        await this.#during("storing", () =>
            this.#attempt(async () => {
                const { motions, store } = this;

                if (motions.isEmpty) throw new MotionError("motion-empty");
                motions.check();
                await store.load();
                const { poses, sequences } = store.replaced(motions);
                const names = [...poses, ...sequences];

                if (names.length && !(await this.ask(textOfQuestion(names)))) return;
                await store.store(this.#newOf(motions));
                motions.isChanged = false;
                this.#tell("motion-stored");
            }),
        );
    }

    /* What the board has already need not be written again. */
    #newOf(motions) {
        const { stored } = this.store;
        const part = new Motions({ keywords: this.keywords });
        const isNew = (kept, lines) => ([name, now]) => !kept.has(name) || String(lines(name, now)) !== String(lines(name, kept.get(name)));

        part.poses = new Map([...motions.poses].filter(isNew(stored.poses, linesOfPose)));
        part.sequences = new Map([...motions.sequences].filter(isNew(stored.sequences, linesOfSequence)));
        return part;
    }

    #tell(code) {
        this.session.notify({ code, poses: this.motions.poses.size, sequences: this.motions.sequences.size });
    }

    get text() {
        this.motions.isChanged = false;
        return textOfMotions(this.motions);
    }

    async open(text, askFirst) {
        const motions = await this.#attempt(async () => {
            const read = readMotions(text, { keywords: this.keywords });

            if (read.motions.isEmpty) throw new MotionError("motion-file-empty");
            if (read.gone.length) this.session.notify({ code: "motion-gone", names: read.gone });
            return read.motions;
        });

        if (!motions || (this.motions.isChanged && !(await this.ask(askFirst)))) return;
        this.#takeMotions(motions);
        this.motions.isChanged = true; // the board does not have it
        this.#tell("motion-loaded");
    }
}

/* Where the joints are at the end of the steps. */
function lastPositions(steps, poses) {
    const all = new Map();

    for (const { pose } of steps) for (const [id, raw] of poses.get(pose)) all.set(id, raw);
    return all;
}
