// SPDX-License-Identifier: MIT
/* Teach, record, edit, play, store: the view of model/motion_desk.js. */

import { html, nothing } from "lit/html.js";
import { guard } from "lit/directives/guard.js";
import { live } from "lit/directives/live.js";
import { MotionDesk } from "../model/motion_desk.js";
import { STEPS_MAX } from "../model/motions.js";
import { pathOfPoints } from "../model/path.js";
import { degreesOf, typedNumber } from "../model/units.js";
import { texts } from "../texts/texts.js";
import { confirmed } from "./confirm.js";
import { chart, legend, playhead } from "./motion_chart.js";
import { textOfFile } from "./read_file.js";
import { saveFile } from "./save_file.js";
import { keepsTyping, taken } from "./typing.js";
import { View } from "./view.js";

const t = texts.motion;
const FILE_MAX = 200000; // bytes
const CHART_WIDTH = 600; // until the page is laid out

const degrees = (raw, digits = 1) => degreesOf(raw).toFixed(digits);
const seconds = (ms, digits = 1) => (ms / 1000).toFixed(digits);
const milliseconds = ({ target }) => Math.round(typedNumber(target.value) * 1000);

/* Warnings of steps that are too fast for a servo. `first`: the number of the first step. */
const tooFast = (steps, first = 1) =>
    steps.map(({ index, id, needed }) => html`<p class="warn">${t.tooFast({ step: index + first, id, needed: (Math.ceil(needed / 10) / 100).toFixed(2) })}</p>`);

export class MotionView extends View {
    #width = CHART_WIDTH;
    #proposedName = "";
    #shownRecording = null;
    #resize = new ResizeObserver(([entry]) => {
        this.#width = Math.floor(entry.contentRect.width);
        this.requestUpdate();
    });

    connectedCallback() {
        if (!this.desk) this.#makeView();
        super.connectedCallback();
    }

    /* The browser asks before it leaves the page, if the desk has unsaved changes. */
    #makeView() {
        keepsTyping(this);
        this.desk = new MotionDesk(this.session, { ask: (text, yes) => (this.isConnected ? confirmed({ text, yes, no: t.cancel }) : null) });
        addEventListener("beforeunload", (event) => this.desk.hasUnsaved && event.preventDefault());
    }

    firstUpdated() {
        this.#resize.observe(this.querySelector(".sequence .chart"));
    }

    updated() {
        this.#proposeName();
        this.#showRecording();
        if (this.session.isConnected) this.desk.show();
    }

    /* ---- teach ---- */

    #chip(id) {
        const { desk } = this;
        const { torque, position } = this.session.robot.servos.get(id);
        const hint = t.torqueOf(id, torque);

        return html`<label class="chip ${torque ? "held" : "limp"}" title=${hint}>
            <input type="checkbox" .checked=${live(!desk.unchosen.has(id))} aria-label=${hint}
                @change=${({ target }) => desk.choose(id, target.checked)} />
            ${id} <span class="at">${position === null ? t.noValue : `${position.toFixed(0)}°`}</span>
        </label>`;
    }

    #capture = async (event) => {
        event.preventDefault();
        const input = this.querySelector(".pose-name");

        if (await this.desk.capture(input.value.trim())) input.value = this.#proposedName;
    };

    /* A name that is free, unless the user has typed another. The board may have poses that are not loaded yet. */
    #proposeName() {
        const input = this.querySelector(".pose-name");

        if (input.value === this.#proposedName) input.value = this.#proposedName = this.desk.motions.freeName("pose");
    }

    /* The box of a new recording stands below the sequence: brings it into sight. The focus was on the button that has
     * ended it, which is gone: a screen reader reads the heading. */
    #showRecording() {
        const { latest } = this.desk.recordings;

        if (latest === this.#shownRecording) return;
        this.#shownRecording = latest;
        this.querySelector(".recording").scrollIntoView({ block: "nearest" });
        if (document.activeElement === document.body) this.querySelector(".recording h2").focus({ preventScroll: true });
    }

    #teach() {
        const { desk, session } = this;
        const isOff = !session.isConnected || desk.recordings.isRecording;

        return html`<section class="panel teach" aria-label=${t.teach}>
            <h2>${t.teach}</h2>
            ${desk.ids.length ? nothing : html`<p class="soft">${session.isConnected ? t.noServos : t.notConnected}</p>`}
            <fieldset class="chips" ?disabled=${isOff}>
                <legend>${t.servos}</legend>
                <span class="row">
                    <button @click=${() => desk.chooseAll(true)}>${t.all}</button>
                    <button @click=${() => desk.chooseAll(false)}>${t.none}</button>
                </span>
                ${desk.ids.map((id) => this.#chip(id))}
            </fieldset>
            <p class="row">
                <button class="torque-off" title=${t.torqueOffHint} ?disabled=${!session.isConnected}
                    @click=${() => desk.setTorque(false)}>${t.torqueOff}</button>
                <button class="hold" title=${t.holdHint} ?disabled=${isOff} @click=${() => desk.setTorque(true)}>${t.hold}</button>
            </p>
            <form class="row" @submit=${this.#capture}>
                <label>${t.name}
                    <input class="pose-name" size="9" aria-label=${t.poseName} autocomplete="off" spellcheck="false" /></label>
                <button class="capture" ?disabled=${isOff}>${t.capture}</button>
                <span class="soft">${t.nameHint}</span>
            </form>
            <p class="row">
                ${desk.recordings.isRecording
                    ? html`<button class="record" @click=${() => desk.recordings.end()}>${t.endRecording}</button>
                          <span class="recording-length" role="timer">${seconds(desk.recordings.recorder.recording.length)} s</span>`
                    : html`<button class="record" ?disabled=${isOff || desk.isPlaying}
                              @click=${() => desk.recordings.begin()}>${t.record}</button>
                          <span class="soft">${t.recordHint}</span>`}
            </p>
        </section>`;
    }

    /* ---- poses ---- */

    #poseRow([name, pose]) {
        const { desk } = this;
        const isShown = desk.pose === name;

        return html`<li class=${isShown ? "pose shown" : "pose"} data-pose=${name}>
            <button class="open" aria-expanded=${isShown} aria-label=${t.editOf(name)} @click=${() => desk.showPose(name)}>
                <span aria-hidden="true">${isShown ? "▾" : "▸"}</span>
                <strong>${name}</strong> <span class="soft">${t.servosOf(pose)}</span>
            </button>
            <button class="go" aria-label=${t.goToOf(name)} ?disabled=${!this.session.isConnected || desk.isPlaying}
                @click=${() => desk.goTo(name)}>
                ${t.goTo}
            </button>
            <button class="delete" aria-label=${t.deletePoseOf(name)} title=${t.deletePoseOf(name)}
                @click=${() => desk.deletePose(name)}>×</button>
            ${isShown ? this.#poseEditor(name, pose) : nothing}
        </li>`;
    }

    #poseEditor(name, pose) {
        const { desk } = this;

        return html`<div class="editor">
            <p class="row">
                <label>${t.name}
                    <input class="own-name" size="9" title=${t.nameHint} .value=${taken(name)}
                        @change=${({ target }) => desk.renamePose(target.value.trim())} /></label>
                <button ?disabled=${!this.session.isConnected} @click=${() => desk.recapture()}>${t.fromServos}</button>
            </p>
            <div class="angles">
                ${[...pose].map(
                    ([id, raw]) => html`<label>
                        ${t.angle(id)}
                        <span class="unit">
                            <input inputmode="decimal" data-id=${id} .value=${taken(degrees(raw))}
                                @change=${({ target }) => desk.setAngle(id, typedNumber(target.value))} />°
                        </span>
                        <button class="delete" aria-label=${t.angleOut(id)} title=${t.angleOut(id)} ?disabled=${pose.size === 1}
                            @click=${() => desk.removeJoint(id)}>×</button>
                    </label>`,
                )}
            </div>
        </div>`;
    }

    #poses() {
        const poses = [...this.desk.motions.poses];

        return html`<section class="panel poses" aria-label=${t.poses}>
            <h2>${t.poses}</h2>
            ${poses.length
                ? html`<ul class="list">${poses.map((entry) => this.#poseRow(entry))}</ul>`
                : html`<ol class="first soft">${t.noPoses.map((step) => html`<li>${step}</li>`)}</ol>`}
        </section>`;
    }

    /* ---- sequence ---- */

    #stepRow(step, index) {
        const { desk } = this;
        const number = index + 1;
        const time = (name, value) => html`<label class="time-of">
            <span class="cap">${t[name]}</span>
            <input inputmode="decimal" class=${name} aria-label=${t.ofStep(t[name], number)}
                .value=${taken(seconds(value, 2))}
                ?disabled=${name === "dwell" && step.passes}
                @change=${(event) => desk.changeStep(index, { [name]: milliseconds(event) })} />
        </label>`;
        const button = (name, sign, isOff, call) => html`<button class=${name} title=${t.ofStep(t[name], number)}
            aria-label=${t.ofStep(t[name], number)} ?disabled=${isOff} @click=${call}>${sign}</button>`;

        return html`<li class=${index === desk.step ? "step selected" : "step"} data-step=${number} aria-current=${index === desk.step}>
            <label class="number"><span class="cap">${t.step}</span>
                <span><input type="radio" name="motion-step" .checked=${live(index === desk.step)} aria-label=${`${t.step} ${number}`}
                    @change=${() => desk.showStep(index)} />${number}</span>
            </label>
            <label class="pose-of"><span class="cap">${t.pose}</span>
                <select aria-label=${t.ofStep(t.pose, number)} @change=${({ target }) => desk.changeStep(index, { pose: target.value })}>
                    ${[...desk.motions.poses.keys()].map((name) => html`<option .selected=${live(name === step.pose)}>${name}</option>`)}
                </select>
            </label>
            ${time("time", step.time)} ${time("dwell", step.dwell)}
            <label class="pass" title=${t.passHint}><span class="cap">${t.pass}</span>
                <input type="checkbox" .checked=${live(step.passes)} aria-label=${t.ofStep(t.pass, number)}
                    @change=${({ target }) => desk.changeStep(index, { passes: target.checked })} />
            </label>
            <span class="buttons">
                ${button("up", "↑", index === 0, () => desk.moveStep(index, -1))}
                ${button("down", "↓", index === desk.steps.length - 1, () => desk.moveStep(index, 1))}
                ${button("remove", "×", false, () => desk.removeStep(index))}
            </span>
        </li>`;
    }

    #sequenceChart() {
        const { desk } = this;
        const { path, steps } = desk;

        if (!steps.length) return html`<p class="soft">${desk.motions.poses.size ? t.noSequences : t.noPosesYet}</p>`;
        const label = `${t.chart}: ${t.chartText({ steps: steps.length, seconds: seconds(path.duration, 2), servos: path.ids.length })}`;
        const sequence = { steps, selected: desk.step, onSelect: (index) => desk.showStep(index) };

        return html`${chart({ path, width: this.#width, label, sequence })} ${legend(path.ids, t.angle)} ${tooFast(desk.stepsTooFast)}`;
    }

    /* Its curves are made again only if they have changed. */
    #chart(duration, time, render) {
        return html`<div class="chart">
            ${guard([this.desk.version, this.#width, this.desk.isLoop], render)}${playhead(duration, this.#width, time)}
        </div>`;
    }

    #sequence() {
        const { desk } = this;
        const names = [...desk.motions.sequences.keys()];

        return html`<section class="panel sequence" aria-label=${t.sequence}>
            <h2>${t.sequence}</h2>
            <p class="row">
                <label>${t.sequence}
                    <select class="choose" ?disabled=${!names.length} @change=${({ target }) => desk.showSequence(target.value)}>
                        ${names.length ? nothing : html`<option disabled selected>${t.noSequence}</option>`}
                        ${names.map((name) => html`<option .selected=${live(name === desk.sequence)}>${name}</option>`)}
                    </select>
                </label>
                ${desk.sequence
                    ? html`<label>${t.name}
                              <input class="sequence-name" size="9" title=${t.nameHint} .value=${taken(desk.sequence)}
                                  @change=${({ target }) => desk.renameSequence(target.value.trim())} /></label>
                          <button @click=${() => desk.deleteSequence()}>${t.deleteSequence}</button>`
                    : nothing}
                <button class="new" @click=${() => desk.newSequence()}>${t.newSequence}</button>
            </p>
            ${this.#chart(desk.path.duration, desk.playhead(), () => this.#sequenceChart())}
            ${desk.steps.length
                ? html`<div class="caps" aria-hidden="true">
                      ${[t.step, t.pose, t.time, t.dwell, t.pass].map((text) => html`<span>${text}</span>`)}
                  </div>`
                : nothing}
            <ol class="steps">${desk.steps.map((step, index) => this.#stepRow(step, index))}</ol>
            <p class="row"><button class="add-step" @click=${() => desk.addStep()}>${t.addStep}</button></p>
            ${desk.steps.length ? html`<p class="soft">${t.stepsHint}</p>` : nothing}
        </section>`;
    }

    /* ---- recording ---- */

    #recordingChart() {
        const { latest: recording, thinned, replay } = this.desk.recordings;
        const path = pathOfPoints(recording.ids, recording.samples);
        const curves = { path, width: this.#width, label: t.chartOfRecording, other: replay?.samples ?? [], points: thinned.points };

        return html`${chart(curves)}${legend(recording.ids, t.angle)}`;
    }

    /* Play and the new sequence stand above. */
    #toSequence = async () => {
        await this.desk.recordings.toSequence();
        this.querySelector(".player").scrollIntoView();
    };

    #recordingButtons(isTooLong) {
        const { desk, session } = this;
        const { recordings } = desk;
        const isOff = !session.isConnected || desk.isPlaying || recordings.isRecording;

        return html`<button class="replay" title=${t.replayHint} ?disabled=${isOff} @click=${() => desk.playRecording()}>${t.replay}</button>
            <button class="to-sequence" ?disabled=${isTooLong} @click=${this.#toSequence}>${t.toSequence}</button>
            <button @click=${() => saveFile("recording.csv", recordings.exportCsv(), "text/csv")}>${t.saveRecording}</button>`;
    }

    #recording() {
        const { desk } = this;
        const { recordings } = desk;
        const { latest: recording, thinned, replay } = recordings;

        if (!recording) return nothing;
        const { length, rate, ids } = recording;
        const isTooLong = thinned.points.length > STEPS_MAX;
        const facts = { seconds: seconds(length, 2), rate: rate.toFixed(0), servos: ids.length };

        return html`<section class="panel recording" aria-label=${t.recording}>
            <h2 tabindex="-1">${t.recording}</h2>
            <p class="recorded">
                ${t.recordingIs(facts)}
                ${recording.missing ? html`<span class="warn">${t.missing(recording.missing)}</span>` : nothing}
            </p>
            ${this.#chart(length, desk.playhead(recording), () => this.#recordingChart())}
            <p class="row">
                <label>${t.tolerance}
                    <span class="unit"><input class="tolerance" inputmode="decimal"
                        .value=${taken(recordings.tolerance.toFixed(1))}
                        @change=${({ target }) => recordings.setTolerance(typedNumber(target.value))} />°</span>
                </label>
                <button class="fit" title=${t.fitHint} @click=${() => recordings.fit()}>${t.fit}</button>
                <output class="thinned">${t.thinned({ steps: thinned.points.length, error: degrees(thinned.error) })}</output>
            </p>
            ${isTooLong ? html`<p class="warn">${t.tooLong}</p>` : nothing}
            ${recordings.isCoarse ? html`<p class="warn coarse">${t.coarse(recordings.tolerance.toFixed(1))}</p>` : nothing}
            ${tooFast(thinned.tooFast, 2)}
            <p class="row">${this.#recordingButtons(isTooLong)}</p>
            ${replay
                ? html`<p class="replayed" role="status">
                      ${t.replayed({ largest: degrees(replay.largest), id: replay.id, percent: replay.percent, mean: degrees(replay.mean) })}
                  </p>`
                : nothing}
        </section>`;
    }

    /* ---- play ---- */

    #stateOfMotion() {
        const { desk, session } = this;
        const motion = session.robot?.motion;

        if (desk.task === "storing") return t.storing;
        if (desk.player.state === "begin") return t.pageBegins;
        if (desk.player.isPlaying) return t.pagePlays({ seconds: seconds(desk.player.time), paused: desk.player.isPaused });
        if (!session.isConnected || !motion?.state) return t.idle;
        if (motion.state === 1) return t.begins;
        const name = desk.store.playing;

        return t.boardPlays({ name, step: motion.step, steps: desk.store.stored.sequences.get(name)?.length, paused: motion.paused });
    }

    /* Pause or Resume, End, and the state of the motion. */
    #playControls() {
        const { desk } = this;
        const { isPlaying, isPaused } = desk;

        return html`<button class=${isPaused ? "resume" : "pause"} ?disabled=${!isPlaying && !isPaused} @click=${() => desk.togglePause()}>
                ${isPaused ? t.resume : t.pause}
            </button>
            <button class="end" ?disabled=${!isPlaying && !desk.isStarting} @click=${() => desk.end()}>${t.end}</button>
            <span class="motion-state" role="status">${this.#stateOfMotion()}</span>
            ${desk.task === "storing" ? html`<progress aria-label=${t.storing} .value=${desk.store.progress}></progress>` : nothing}`;
    }

    #player() {
        const { desk, session } = this;
        const { isPlaying } = desk;
        const isFixed = isPlaying || desk.isStarting;
        const isUnknown = desk.isBoardPlaying && !desk.isOwn; // begun before this page was connected, or by a line

        return html`<section class="panel player ${isPlaying || desk.task ? "busy" : ""}" aria-label=${t.player}>
            <h2>${t.player}</h2>
            <p class="row">
                <label>${t.where}
                    <select class="by" ?disabled=${!desk.store.canPlay} @change=${({ target }) => (desk.by = target.value)}>
                        <option value="board" .selected=${live(desk.playedBy === "board")}>${t.byBoard}</option>
                        <option value="page" .selected=${live(desk.playedBy === "page")}>${t.byPage}</option>
                    </select>
                </label>
                <label>${t.times} <input class="times" inputmode="numeric" ?disabled=${desk.isLoop || isFixed}
                    placeholder=${t.unknown} .value=${taken(isUnknown ? "" : String(desk.times))}
                    @change=${({ target }) => (desk.times = Math.min(65535, Math.max(1, Math.round(typedNumber(target.value)) || desk.times)))} /></label>
                <label title=${isFixed ? t.fixed : nothing}>
                    <input class="loop" type="checkbox" .checked=${live(desk.isLoop)} .indeterminate=${isUnknown} ?disabled=${isFixed}
                        @change=${({ target }) => desk.setLoop(target.checked)} /> ${t.loop}
                </label>
                <label class="speed">${t.override}
                    <input class="override" type="range" min="10" max="200" step="5" .value=${taken(String(desk.percent))}
                        @change=${({ target }) => desk.setPercent(Number(target.value))} />
                    <output>${desk.percent} %</output>
                </label>
            </p>
            <p class="row">
                <button class="play" ?disabled=${!session.isConnected || isPlaying || desk.task || !desk.steps.length}
                    title=${desk.needsStore ? t.storeAndPlayHint : nothing} @click=${() => desk.play()}>
                    ${desk.needsStore ? t.storeAndPlay : t.play} ${desk.sequence}
                </button>
                ${this.#playControls()}
            </p>
        </section>`;
    }

    /* ---- board and files ---- */

    #open = async ({ target }) => {
        const [file] = target.files;

        target.value = "";
        const text = file && (await this.session.attempt(() => textOfFile(file, FILE_MAX), "open"));

        if (text !== undefined) await this.desk.open(text);
    };

    #board() {
        const { desk, session } = this;
        const { canStore, canPlay, room } = desk.store;
        const isOff = !canStore || Boolean(desk.task) || desk.isPlaying;

        return html`<section class="panel board" aria-label=${t.board}>
            <h2>${t.board}</h2>
            <div class="files">
                <button class="store" ?disabled=${isOff} @click=${() => desk.storeAll()}>
                    ${desk.task === "storing" ? t.storing : t.store}
                </button>
                <button class="load" ?disabled=${isOff} @click=${() => desk.load()}>
                    ${desk.task === "loading" ? t.loading : t.load}
                </button>
                <button class="export" ?disabled=${desk.motions.isEmpty}
                    @click=${() => saveFile("motions.txt", desk.exportText())}>${t.exportFile}</button>
                <label class="file">${t.importFile} <input class="import" type="file" accept=".txt,text/plain" @change=${this.#open} /></label>
            </div>
            ${session.isConnected && !canStore ? html`<p class="warn missing">${t.noStore}</p>` : nothing}
            ${canStore && !canPlay ? html`<p class="warn missing">${t.noPlay}</p>` : nothing}
            ${canStore && room ? html`<p class="soft">${t.room(room)}</p>` : nothing}
        </section>`;
    }

    render() {
        return html`<div class="motion">
                <div class="column">${this.#teach()} ${this.#poses()} ${this.#board()}</div>
                <div class="column wide">${this.#player()} ${this.#sequence()} ${this.#recording()}</div>
            </div>`;
    }
}

customElements.define("panel-motion", MotionView);
