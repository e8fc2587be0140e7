// SPDX-License-Identifier: MIT
/* What the view Motion works on: the poses and sequences of the page, and what is done with them: play, store on
 * the board, files. */

import { alarms } from "../texts/alarms.js";
import { texts } from "../texts/texts.js";
import { readMotions, textOfMotions } from "./motion_text.js";
import { MotionEditor } from "./motion_editor.js";
import { MotionStore } from "./motion_store.js";
import { MotionError, Motions } from "./motions.js";
import { lastPositions, pathOfPoints, pathOfSequence } from "./path.js";
import { Player, torqueError } from "./player.js";
import { compare } from "./recording.js";
import { Recordings } from "./recordings.js";

const ERROR_NO_MOTION = 79; // the motion was ended
const ERROR_STUCK = 83; // a servo does not follow its goals
const ERROR_TORQUE_OFF = 84;
const BEGINS = 1; // register MOTION_STATE
const UNDER_WAY = 2;
const WAIT_MS = 1000; // the motion has ended already
const t = texts.motion;

/* ["pose NAME", "sequence NAME"] */
const namesOf = ({ poses, sequences }) => [...[...poses.keys()].map((name) => `pose ${name}`), ...[...sequences.keys()].map((name) => `sequence ${name}`)];

export class MotionDesk extends MotionEditor {
    #loadedFrom = null; // the controller whose poses and sequences were read; null: none, or they may have changed since
    #isOld = false; // a line by hand came during the load
    #onBoard = new Motions(); // what the page has loaded from the board, or stored there
    #shownOf = null; // the controller that was asked for them when the view was shown
    #motionState = 0;
    #isStopped = false; // the user has stopped the motion that is or was under way
    #robot = null;
    #isEnding = false; // the user has pressed End before the board plays
    #played = null; // the recording, or the text of the sequence, that the page plays
    #step = 0; // that the board plays, since #stepSeen,
    #stepSeen = 0;
    #stepTime = 0; // at this time of the step, in ms

    /* `ask(text, yes)` returns null if the view was left: then it cannot ask. */
    constructor(session, { ask } = {}) {
        super(session, ask);
        this.store = new MotionStore(session);
        this.player = new Player(session);
        this.recordings = new Recordings(this);
        this.percent = 100;
        this.by = "board"; // or page
        this.isStarting = false; // play() has not ended
        this.isOwn = false; // this page has begun what the board plays: `times` and `isLoop` are those of the board
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

    /* Plays the recording from the page, and measures how well the servos follow it. */
    playRecording() {
        const { latest: recording } = this.recordings;
        const path = pathOfPoints(recording.ids, recording.samples);
        const { percent } = this;

        return this.attempt(async () => {
            this.#begin(recording);
            if (!(await this.player.play(path))) return;
            const { samples } = this.player;
            const result = compare(path, samples);

            this.recordings.replay = { ...result, samples, percent, id: recording.ids[result.joint] };
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
        if (this.isStarting || this.task) return;
        this.isStarting = true;
        this.#isEnding = false;
        await this.attempt(async () => {
            if (!this.steps.length) throw new MotionError("motion-no-steps", { detail: this.sequence });
            await (this.playedBy === "board" ? this.#playByBoard() : this.#playByPage());
        }, "play");
        this.isStarting = false;
    }

    /* True if the board is known to lack the sequence, or to have it with other contents: play() stores it first. */
    get needsStore() {
        return this.playedBy === "board" && this.#loadedFrom === this.session.controller && this.steps.length > 0 && !this.store.newOf(this.#shown).isEmpty;
    }

    get #shown() {
        return this.motions.partOf(this.sequence);
    }

    async #playByBoard() {
        const { sequence, store, isLoop, times } = this;
        const { robot } = this.session;
        const part = this.#shown; // the user may go on editing
        const off = part.joints.filter((id) => {
            const { torque, presence } = robot.servos.get(id) ?? {};

            return torque === false || presence === "offline";
        });

        if (robot.isInhibited) throw new MotionError("motion-inhibited");
        if (off.length) throw torqueError(robot, off);
        await this.#loadStored();
        if (!this.store.newOf(part).isEmpty && !(await this.#during("storing", () => this.#store(part), "play"))) return;
        if (this.#isEnding) return;
        await store.play(sequence, { times: isLoop ? 0 : times, percent: this.percent });
        this.session.takeMotion();
        robot.motion = { ...robot.motion, override: this.percent, state: BEGINS }; // until it is read
        this.isOwn = true;
        if (this.#isEnding) await store.end();
    }

    async #playByPage() {
        const part = this.#shown; // a copy: poses may be renamed meanwhile
        const { poses } = part;
        const steps = part.sequences.get(this.sequence);

        this.#begin(textOfMotions(part));
        let start = new Map(this.ids.map((id) => [id, this.session.robot.servos.get(id).raw.position]));

        for (let left = this.isLoop ? Infinity : this.times; left > 0; left--) {
            if (!(await this.player.play(pathOfSequence(steps, poses, start)))) return;
            start = lastPositions(steps, poses);
        }
    }

    /* The time of the sequence that is shown, or of `recording`, while it plays, in ms; else NaN, also for a sequence that was
     * edited since. The board tells the step only: the page counts the time since then. */
    playhead(recording) {
        const { player, session, steps, store } = this;
        const { state, step = 0, paused, override } = session.robot?.motion ?? {};

        if (player.isPlaying) return player.state === "playing" && this.#played === (recording ?? (this.sequence && textOfMotions(this.#shown))) ? player.time : NaN;
        if (state !== UNDER_WAY || recording || store.playing !== this.sequence || !steps[step - 1] || !store.newOf(this.#shown).isEmpty) return NaN;
        const now = session.clock.now();

        if (step !== this.#step) [this.#step, this.#stepTime] = [step, 0];
        else if (!paused) this.#stepTime += ((now - this.#stepSeen) * override) / 100;
        this.#stepSeen = now;
        const { time, dwell } = steps[step - 1];

        return this.path.begins[step - 1] + Math.min(this.#stepTime, time + dwell);
    }

    #begin(played) {
        this.player.percent = this.percent;
        if (!this.player.isPlaying) this.#played = played;
    }

    setPercent(percent) {
        this.percent = Math.min(Math.max(percent, 10), 200);
        this.player.percent = this.percent;
        if (this.isBoardPlaying) this.attempt(() => this.store.override(this.percent));
        this.changed();
    }

    /* Pauses, or goes on. */
    togglePause() {
        const isPaused = !this.isPaused;

        if (!this.player.isPlaying) return this.attempt(() => this.store.setPaused(isPaused));
        this.player.isPaused = isPaused;
        return this.changed();
    }

    end() {
        this.#isEnding = true;
        if (this.player.isPlaying) return this.player.end();
        return this.isPlaying ? this.attempt(this.store.end) : this.changed();
    }

    /* A new connection, and the end of a motion of the board. */
    #follow() {
        const { robot } = this.session;
        const motion = robot?.motion;

        if (robot !== this.#robot) {
            this.#robot = robot;
            this.#onBoard = new Motions();
            this.#motionState = 0;
        }
        const before = this.#motionState;

        this.#motionState = motion?.state ?? 0;
        this.isOwn &&= this.#motionState > 0;
        if (this.#motionState && before !== this.#motionState) this.percent = motion.override ?? this.percent;
        if (before !== UNDER_WAY) this.#isStopped = false;
        if (this.session.stopState === "stopping") this.#isStopped = true;
        if (this.#isStopped) return;
        if (before !== UNDER_WAY || this.#motionState || !motion?.error || motion.error === ERROR_NO_MOTION) return;
        this.#tellEnd(motion.error);
    }

    /* The register has the number of the error. The console names the first servo even if none answers: then the line or the power is named. */
    async #tellEnd(number) {
        const { session } = this;
        const { lines = [] } = (await session.controller.order("motion wait", { timeout: WAIT_MS }).catch((error) => error)) ?? {};
        const id = /^servo (\d+) /.exec(lines[0])?.[1];
        const { answering, isLineLow, servos } = session.robot;
        const { alarms: reported = [], torque } = servos.get(Number(id)) ?? {};

        if (number === ERROR_STUCK && torque === false) number = ERROR_TORQUE_OFF;
        const { text: message = "", remedy = "" } = session.tables.errors[number] ?? {};
        const cause = servos.size && !answering
            ? { remedy: isLineLow ? texts.robot.lineLow : texts.robot.allSilent }
            : { id, remedy: [...reported.map((name) => alarms[name]), remedy].join(" ") };

        session.notify({ code: "motion-ended", number, message, ...cause });
    }

    /* ---- the board, files ---- */

    /* Runs `call`; a failure is a notice. */
    #during(task, call, input) {
        this.task = task;
        this.changed();
        return this.attempt(call, input).finally(() => {
            this.task = "";
            this.changed();
        });
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
        await this.#during("loading", async () => {
            await this.#loadStored();
            if (this.motions.isEmpty) this.#takeMotions(this.store.stored, true);
        });
    }

    #takeMotions(motions, isOnBoard) {
        const copy = () => readMotions(textOfMotions(motions)).motions;

        this.#onBoard = isOnBoard ? copy() : new Motions();
        this.motions = copy();
        this.motions.keywords = this.keywords;
        this.forgetUndo();
        this.pose = "";
        this.showSequence([...this.motions.sequences.keys()][0] ?? "");
    }

    async #mayReplace(question) {
        const isConfirmed = await this.ask(question, t.replace);

        if (isConfirmed === null) throw new MotionError("motion-not-asked");
        return isConfirmed;
    }

    async load() {
        await this.#during("loading", async () => {
            await this.store.load();
            // Asks now: the user may have changed something during the load.
            if (this.motions.isChanged && !(await this.#mayReplace(t.askReplacePage))) return;
            this.#takeMotions(this.store.stored, true);
            if (this.store.gone.length) this.session.notify({ code: "motion-gone", names: this.store.gone });
            this.#notifyCounts("motion-loaded");
        }, "load");
    }

    async storeAll() {
        if (this.task) return; // the button was pressed twice
        await this.#during("storing", async () => {
            const { motions, store } = this;

            if (motions.isEmpty) throw new MotionError("motion-empty");
            motions.check();
            const sent = readMotions(textOfMotions(motions)).motions; // the user may go on editing

            await store.load();
            if (await this.#store(sent)) await this.#removeGone(sent);
        }, "store");
    }

    /* Offers to delete on the board what was renamed or deleted here. A pose that a sequence of the board needs stays. */
    async #removeGone(sent) {
        const { stored } = this.store;
        const isGone = (name) => namesOf(this.#onBoard).includes(name) && !namesOf(sent).includes(name);
        const needed = [...stored.sequences].flatMap(([name, steps]) => (isGone(`sequence ${name}`) ? [] : steps.map(({ pose }) => `pose ${pose}`)));
        const gone = namesOf(stored).filter((name) => isGone(name) && !needed.includes(name));

        if (gone.length && (await this.ask(t.askRemove(gone), t.remove))) await this.store.remove(gone);
        this.#onBoard = sent;
    }

    /* Stores `sent`, a copy of motions or of a part. False: the user keeps what the board has. */
    async #store(sent) {
        const { motions, store } = this;
        const names = store.replaced(sent, this.#onBoard);

        if (names.length && !(await this.#mayReplace(t.askReplaceBoard(names)))) return false;
        await store.store(store.newOf(sent));
        for (const kind of ["poses", "sequences"]) for (const entry of sent[kind]) this.#onBoard[kind].set(...entry);
        motions.isChanged &&= ![sent, this.#onBoard].some((known) => textOfMotions(known) === textOfMotions(motions));
        this.session.takeMotion();
        this.#notifyCounts("motion-stored", sent);
        return true;
    }

    #notifyCounts(code, { poses, sequences } = this.motions) {
        this.session.notify({ code, poses: poses.size, sequences: sequences.size });
    }

    /* The text of a file. What it has is saved. */
    exportText() {
        this.motions.isChanged = false;
        return textOfMotions(this.motions);
    }

    async open(text) {
        const motions = await this.attempt(async () => {
            const read = readMotions(text, { keywords: this.keywords });

            if (read.motions.isEmpty) throw new MotionError("motion-file");
            if (read.gone.length) this.session.notify({ code: "motion-gone", names: read.gone });
            return !this.motions.isChanged || (await this.#mayReplace(t.askReplacePage)) ? read.motions : null;
        }, "open");

        if (!motions) return;
        this.#takeMotions(motions);
        this.#notifyCounts("motion-loaded");
    }
}
