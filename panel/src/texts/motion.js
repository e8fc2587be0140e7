// SPDX-License-Identifier: MIT
/* The view Motion, and its notices. */

import { alarms } from "./alarms.js";
import { list, many } from "./words.js";

const NAME = "up to 8 letters and digits, first a letter, no word of the console";

export const motion = {
    notConnected: "Connect to teach and play. Editing needs no connection.",
    noStore: "This firmware stores no poses and sequences: save a file. The page plays them.",
    noPlay: "This board stores poses and sequences. The page plays them.",

    noValue: "–",
    teach: "Teach",
    servos: "Servos",
    all: "All",
    none: "None",
    torqueOff: "Torque off",
    torqueOffHint: "The chosen servos go limp: support the robot",
    hold: "Torque on",
    holdHint: "The chosen servos hold where they are now",
    noServos: "No servo is known. Find servos in the view Robot.",
    torqueOf: (id, torque) => `Servo ${id}, torque ${torque === null ? "not known" : torque ? "on" : "off"}`,
    poseName: "Name of the pose",
    nameHint: NAME,
    capture: "Capture pose",
    record: "Record",
    recordHint: "Keeps how you lead the chosen servos by hand, torque off",
    askTorqueOff: (ids) => `Torque is on: ${list(ids)}. Without torque the robot may fall: support it first.`,
    torqueOffAndRecord: "Torque off and record",
    endRecording: "End recording",

    poses: "Poses",
    noPoses: ["Choose servos and press “Torque off”.", "Turn them by hand.", "Press “Capture pose”, once for each pose."],
    goTo: "Go there",
    goToOf: (name) => `Go to pose ${name}`,
    editOf: (name) => `Edit pose ${name}`,
    deletePoseOf: (name) => `Delete pose ${name}`,
    servosOf: (pose) => many(pose.size, "servo"),
    angle: (id) => `Servo ${id}`,
    angleOut: (id) => `Take servo ${id} out of the pose`,
    fromServos: "Take present positions",
    name: "Name",

    recording: "Recording",
    recordingIs: ({ seconds, rate, servos }) =>
        `${seconds} s of ${many(servos, "servo")}, ${rate} samples a second`,
    missing: (count) => `${many(count, "position is", "positions are")} missing`,
    tolerance: "Error of the steps, at most",
    fit: "Fit into 16 steps",
    fitHint: "With the smallest error",
    thinned: ({ steps, error }) => `${many(steps, "step")}, at most ${error}° from the recording when they play.`,
    tooLong: "More than 16 steps: press “Fit into 16 steps”, or permit a larger error.",
    coarse: (chosen) => `That is more than the ${chosen}° that you chose. Record a shorter movement.`,
    replay: "Replay the recording",
    replayHint: "Once, at the Speed of the box Play",
    replayed: ({ largest, id, mean, percent }) => `Replay at ${percent} %: largest error ${largest}° (servo ${id}), mean ${mean}°`,
    toSequence: "Make a sequence of the steps",
    saveRecording: "Save as CSV",

    sequence: "Sequence",
    noSequence: "none yet",
    noSequences: "Add a step to begin a sequence.",
    noPosesYet: "First capture poses in the box Teach, or open a file. Then add a step.",
    newSequence: "New",
    deleteSequence: "Delete sequence",
    step: "Step",
    pose: "Pose",
    time: "Time, s",
    dwell: "Rest, s",
    pass: "Pass",
    passHint: "Pass: goes through the pose without a stop",
    addStep: "Add step",
    stepsHint: "Time: from the pose before; in step 1 from where the servos are. Click the curves to choose a step.",
    up: "Up",
    down: "Down",
    remove: "Remove",
    ofStep: (what, number) => `${what}, step ${number}`,
    chart: "Curves of the sequence",
    chartText: ({ steps, seconds, servos }) => `${many(steps, "step")}, ${seconds} s, ${many(servos, "servo")}`,
    chartOfRecording: "Curves of the recording and replay",
    tooFast: ({ step, id, needed }) => `Step ${step} is too short: servo ${id} needs ${needed} s.`,

    player: "Play",
    where: "Played by",
    byBoard: "the board",
    byPage: "this page",
    times: "Times",
    loop: "Loop",
    unknown: "unknown",
    fixed: "Press End first",
    override: "Speed",
    play: "Play",
    pause: "Pause",
    resume: "Resume",
    end: "End",
    idle: "Nothing plays.",
    begins: "A motion begins.",
    boardPlays: ({ name, step, steps, paused }) =>
        `${name || "A move"} plays${step ? `: step ${step}${steps ? " of " + steps : ""}` : ""}${paused ? ", paused" : ""}.`,
    pageBegins: "The servos go to the start position.",
    pagePlays: ({ seconds, paused }) => `The page plays: ${seconds} s${paused ? ", paused" : ""}.`,

    board: "Board and files",
    storeAndPlay: "Store and play",
    storeAndPlayHint: "The board does not have the sequence as it is here",
    store: "Store on the board",
    load: "Load from the board",
    exportFile: "Save as a file",
    importFile: "Open a file",
    room: ({ poses, sequences }) => `Free on the board: ${many(poses, "pose")}, ${many(sequences, "sequence")}.`,
    storing: "Storing …",
    loading: "Loading …",
    askReplaceBoard: (names) => `The board has other contents for ${names.join(", ")}. Replace them?`,
    askRemove: (names) => `Renamed or deleted here, and still on the board: ${names.join(", ")}. Remove there, too?`,
    askReplacePage: "Poses and sequences here have unsaved changes. Replace them?",
    replace: "Replace",
    cancel: "Cancel",
};

const inLine = (line) => (line ? `Nothing was loaded. Line ${line}: ` : "");

export const motionNotices = {
    "motion-name": ({ detail, line }) => ({
        text: `${inLine(line)}“${detail}” cannot be a name.`,
        remedy: `Give a name: ${NAME}.`,
    }),
    "motion-twice": ({ detail }) => ({ text: `The name “${detail}” is taken.`, remedy: "Choose another name." }),
    "motion-angle": ({ detail }) => ({ text: `An angle is out of range: ${detail}.`, remedy: "Give 0 to 300 degrees." }),
    "motion-deleted": ({ detail }) => ({ text: `${detail} is deleted.`, remedy: "", level: "info" }),
    "motion-pose-used": ({ detail, users }) => ({
        text: `Pose “${detail}” is a step of ${users.join(", ")}.`,
        remedy: "Remove these steps first.",
    }),
    "motion-steps": ({ detail, count }) => ({
        text: `Sequence “${detail}” would have ${count} steps. The board takes 16.`,
        remedy: "Remove steps, or begin another sequence.",
    }),
    "motion-no-steps": ({ detail }) => ({
        text: `Sequence “${detail}” has no step.`,
        remedy: "Add a step, or delete the sequence.",
    }),
    "motion-no-pose": ({ detail, pose, line }) => ({
        text: `${inLine(line)}there is no pose “${pose}” (${detail}).`,
        remedy: "Capture it first. In a file its line stands before the sequence.",
    }),
    "motion-time": ({ detail, line }) => ({
        text: `${inLine(line)}a time cannot be stored: ${detail}.`,
        remedy: "Give a time of 0.01 to 600 s and a rest of 0 to 65.53 s, with two decimals.",
    }),
    "motion-joints": ({ count }) => ({
        text: `The poses have ${count} servos. The board stores poses of 18 servos.`,
        remedy: "Delete poses, or take servos out of them.",
    }),
    "motion-file": ({ line, why }) => ({
        text: `${line ? `Line ${line} of the file is damaged: ${why}` : "The file has neither poses nor sequences"}. Nothing was loaded.`,
        remedy: "Choose a file that this page has saved, or lines of “pose show” and “sequence show”.",
    }),
    "motion-gone": ({ names }) => ({
        text: `Not loaded: ${names.join(", ")}. A step names a pose that was deleted.`,
        remedy: "Store it again, or delete it with “sequence delete”.",
        level: "warning",
    }),
    "motion-room": ({ poses, sequences, room }) => ({
        text: `The board has room for ${room.poses} poses and ${room.sequences} sequences; this needs ${poses} and ${sequences}. Nothing was stored.`,
        remedy: "Delete some with “pose delete” or “sequence delete”.",
    }),
    "motion-stored": ({ poses, sequences }) => ({
        text: `The board has confirmed ${many(poses, "pose")} and ${many(sequences, "sequence")}.`,
        remedy: "",
        level: "info",
    }),
    "motion-loaded": ({ poses, sequences }) => ({
        text: `Loaded: ${many(poses, "pose")} and ${many(sequences, "sequence")}.`,
        remedy: "",
        level: "info",
    }),
    "motion-taken-back": () => ({
        text: "Not all could be stored. The board has what it had before.",
        remedy: "Remove the cause, then store again.",
        level: "warning",
    }),
    "motion-half": ({ names, why }) => ({
        text: `Storing has ended (${why}). Not known to be on the board: ${names.join(", ")}.`,
        remedy: "Connect again, then store again.",
    }),
    "motion-not-kept": ({ names }) => ({
        text: `The board does not have what was stored: ${names.join(", ")}.`,
        remedy: "Store again. The EEPROM may be worn: see “status”.",
    }),
    "motion-none": () => ({
        text: "Refused: no motion is under way, or the EEPROM is being written.",
        remedy: "Try again.",
    }),
    "motion-ended": ({ id, number, message, remedy }) => ({
        text: `${id ? `Servo ${id}: the` : "The"} motion has ended with error ${number}: ${message}.`,
        remedy,
    }),
    "motion-playing": () => ({ text: "A motion plays already.", remedy: "End it, or wait for its end." }),
    "motion-inhibited": () => ({
        text: "Driving is inhibited. No goal is sent.",
        remedy: "Remove the cause, press Release, then switch torque on.",
    }),
    "motion-torque": ({ ids, names = [], isInhibited }) => ({
        text: `Torque is not on: ${list(ids)}. No goal is sent.`,
        remedy: [...[...names].map((name) => alarms[name]), isInhibited ? "Press Release." : "", "Choose these servos and press “Torque on”."].filter(Boolean).join(" "),
    }),
    "motion-endless": ({ ids }) => ({
        text: `Endless turn: ${list(ids)}. Such a servo has no position to go to.`,
        remedy: "Set its angle limits, or leave it out.",
    }),
    "motion-not-there": ({ ids }) => ({
        text: `Did not reach the start position in time: ${list(ids)}. Nothing was played.`,
        remedy: "Look for what blocks the servo, and at its angle limits.",
    }),
    "motion-late": () => ({
        text: "The page was held up. It sends no more goals; the servos hold their last ones.",
        remedy: "Keep this page in front, then play again.",
    }),
    "motion-not-asked": () => ({
        text: "Nothing was replaced: the view Motion was left.",
        remedy: "Start it again.",
    }),
    "motion-none-chosen": () => ({ text: "No servo is chosen.", remedy: "Choose servos in the box Teach." }),
    "motion-offline": ({ ids }) => ({
        text: `No fresh position: ${list(ids)}. Nothing was kept.`,
        remedy: "Check power and wiring.",
    }),
    "motion-empty": () => ({ text: "There is no pose yet.", remedy: "Capture a pose first." }),
    "motion-record-cut": () => ({
        text: "The recording has ended, since the connection is lost.",
        remedy: "Connect again.",
    }),
    "motion-short": () => ({
        text: "The recording is too short.",
        remedy: "Lead the servos by hand while the page records.",
    }),
};
