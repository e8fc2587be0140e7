// SPDX-License-Identifier: MIT
/* What the view Motion works on: the poses and sequences of the page, and what is done with them: play, store on
 * the board, files. */

import { linesOfSequence, linesOfPose, readMotions, textOfMotions } from "./motion_text.js";
import { MotionEditor } from "./motion_editor.js";
import { MotionStore } from "./motion_store.js";
import { MotionError, Motions } from "./motions.js";
import { lastPositions, pathOfPoints, pathOfSequence } from "./path.js";
import { Player } from "./player.js";
import { compare } from "./recording.js";
import { Recordings } from "./recordings.js";

const ERROR_NO_MOTION = 79; // the motion was ended
const BEGINS = 1; // register MOTION_STATE
const UNDER_WAY = 2;
const WAIT_MS = 1000; // the motion has ended already

export class MotionDesk extends MotionEditor {
    #loadedFrom = null; // the controller whose poses and sequences were read; null: none, or they may have changed since
    #isOld = false; // a line by hand came during the load
    #shownOf = null; // the controller that was asked for them when the view was shown
    #motionState = 0;
    #isStopped = false; // the user has stopped the motion that is or was under way
    #robot = null;
    #isStarting = false; // play() has not ended

    /* `ask(text)` resolves with true if the user says yes, and returns null if the view was left: then it cannot ask. */
    constructor(session, { ask } = {}) {
        super(session);
        this.ask = ask;
        this.store = new MotionStore(session);
        this.player = new Player(session);
        this.recordings = new Recordings(this);
        this.times = 1;
        this.percent = 100;
        this.by = "board"; // or page
        this.task = ""; // storing, loading
        session.addEventListener("change", () => this.#follow());
        session.addEventListener("hand", () => {
            this.#loadedFrom = null;
            this.#isOld = true;
        });
    }

    /* True if poses or sequences have changed since they were loaded, stored or saved, or a recording is unsaved. */
    get hasUnsaved() {
        return this.motions.isChanged || this.recordings.isUnsaved;
    }

    /* ---- play ---- */

    goTo(name) {
        return this.attempt(() => this.player.goTo(this.motions.poses.get(name)));
    }

    /* Plays the recording, or the points that it was thinned out to, from the page, and measures how well the
     * servos follow the recording. */
    playRecording({ isThinned = false } = {}) {
        const { latest: recording, thinned } = this.recordings;
        const path = pathOfPoints(recording.ids, recording.samples);

        return this.attempt(async () => {
            this.#usePercent();
            if (!(await this.player.play(isThinned ? pathOfPoints(recording.ids, thinned.points) : path, true))) return;
            const { samples } = this.player;
            const result = compare(path, samples);

            this.recordings.replay = { ...result, samples, id: recording.ids[result.joint] };
            this.changed();
        });
    }

    /* "board" or "page": the page plays if the board cannot. */
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

    /* Does nothing if it was called already: the button may be pressed several times before it is disabled. */
    async play() {
        if (this.#isStarting) return;
        this.#isStarting = true;
        await this.attempt(() => (this.playedBy === "board" ? this.#playByBoard() : this.#playByPage()));
        this.#isStarting = false;
    }

    async #playByBoard() {
        const { sequence, store, motions } = this;
        const { robot } = this.session;

        await this.#loadStored();
        if (!store.stored.sequences.has(sequence)) throw new MotionError("motion-not-stored", { detail: sequence });
        const { poses, sequences } = store.replaced(motions.partOf(sequence));

        if (poses.length || sequences.length) throw new MotionError("motion-differs", { detail: sequence });
        await store.play(sequence, { times: this.isLoop ? 0 : this.times, percent: this.percent });
        this.session.takeMotion();
        robot.motion = { ...robot.motion, state: BEGINS }; // until it is read
    }

    async #playByPage() {
        if (!this.steps.length) throw new MotionError("motion-no-steps", { detail: this.sequence });
        const { poses, sequences } = this.motions.partOf(this.sequence); // a copy: poses may be renamed meanwhile
        const steps = sequences.get(this.sequence);

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

    setPercent(percent) {
        this.percent = Math.min(Math.max(percent, 10), 200);
        this.player.percent = this.percent;
        if (this.isBoardPlaying) this.attempt(() => this.store.override(this.percent));
        this.changed();
    }

    pause() {
        if (!this.player.isPlaying) return this.attempt(this.store.pause);
        this.player.isPaused = true;
        return this.changed();
    }

    resume() {
        if (!this.player.isPlaying) return this.attempt(this.store.resume);
        this.player.isPaused = false;
        return this.changed();
    }

    end() {
        if (this.player.isPlaying) return this.player.end();
        return this.attempt(this.store.end);
    }

    /* A new connection, and the end of a motion of the board. */
    #follow() {
        const { robot } = this.session;
        const motion = robot?.motion;

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
        this.#tellEnd(motion.error);
    }

    /* The register has the number of the error. The console names the servo, too. */
    async #tellEnd(number) {
        const { session } = this;
        const { text: message = "", remedy = "" } = session.tables.errors[number] ?? {};
        const { lines = [] } = (await session.controller.order("motion wait", { timeout: WAIT_MS }).catch((error) => error)) ?? {};
        const id = /^servo (\d+) /.exec(lines[0])?.[1];

        session.notify({ code: "motion-ended", id, number, message, remedy });
    }

    /* ---- the board, files ---- */

    async #during(task, call) {
        this.task = task;
        this.changed();
        try {
            return await call();
        } finally {
            this.task = "";
            this.changed();
        }
    }

    /* Reads what the board has: once for each connection, and again after a line by hand, which may write poses. */
    async #loadStored() {
        const { controller } = this.session;

        if (this.#loadedFrom === controller) return;
        do {
            this.#isOld = false;
            await this.store.load();
        } while (this.#isOld);
        this.#loadedFrom = controller;
    }

    /* Loads once per connection. If the page has no poses, those of the board become the page's. A failed load is
     * retried by play(), not here: show() runs on every render. */
    async show() {
        if (!this.store.canStore || this.task || this.#shownOf === this.session.controller) return;
        this.#shownOf = this.session.controller;
        await this.#during("loading", () =>
            this.attempt(async () => {
                await this.#loadStored();
                if (this.motions.isEmpty) this.#takeMotions(this.store.stored);
            }),
        );
    }

    #takeMotions(motions) {
        this.motions = readMotions(textOfMotions(motions)).motions;
        this.motions.keywords = this.keywords;
        this.forgetUndo();
        this.pose = "";
        this.showSequence([...this.motions.sequences.keys()][0] ?? "");
    }

    async #mayReplace(textOfQuestion) {
        const isConfirmed = await this.ask(textOfQuestion);

        if (isConfirmed === null) throw new MotionError("motion-not-asked");
        return isConfirmed;
    }

    async load(askFirst) {
        await this.#during("loading", () =>
            this.attempt(async () => {
                await this.store.load();
                // Asks now: the user may have changed something during the load.
                if (this.motions.isChanged && !(await this.#mayReplace(askFirst))) return;
                this.#takeMotions(this.store.stored);
                if (this.store.gone.length) this.session.notify({ code: "motion-gone", names: this.store.gone });
                this.#notifyCounts("motion-loaded");
            }),
        );
    }

    async storeAll(textOfQuestion) {
        if (this.task) return; // the button was pressed twice
        await this.#during("storing", () =>
            this.attempt(async () => {
                const { motions, store } = this;

                if (motions.isEmpty) throw new MotionError("motion-empty");
                motions.check();
                const text = textOfMotions(motions);
                const sent = readMotions(text).motions; // the user may go on editing

                await store.load();
                const { poses, sequences } = store.replaced(sent);
                const names = [...poses, ...sequences];

                if (names.length && !(await this.#mayReplace(textOfQuestion(names)))) return;
                await store.store(this.#newOf(sent));
                motions.isChanged = textOfMotions(motions) !== text;
                this.session.takeMotion();
                this.#notifyCounts("motion-stored", sent);
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

    #notifyCounts(code, { poses, sequences } = this.motions) {
        this.session.notify({ code, poses: poses.size, sequences: sequences.size });
    }

    /* The text of a file. What it has is saved. */
    exportText() {
        this.motions.isChanged = false;
        return textOfMotions(this.motions);
    }

    async open(text, askFirst) {
        const motions = await this.attempt(async () => {
            const read = readMotions(text, { keywords: this.keywords });

            if (read.motions.isEmpty) throw new MotionError("motion-file-empty");
            if (read.gone.length) this.session.notify({ code: "motion-gone", names: read.gone });
            return !this.motions.isChanged || (await this.#mayReplace(askFirst)) ? read.motions : null;
        });

        if (!motions) return;
        this.session.withdraw(["motion-file", "motion-file-empty"]);
        this.#takeMotions(motions);
        this.motions.isChanged = true; // the board does not have it
        this.#notifyCounts("motion-loaded");
    }
}
