// SPDX-License-Identifier: MIT
/* The views, in the order of their tabs. `id` names the tab in texts.tabs and in the address (#robot). */

import { BoardView } from "./board_view.js";
import { GraphsView } from "./graphs_view.js";
import { MotionView } from "./motion_view.js";
import { PacketsView } from "./packets_view.js";
import { RobotView } from "./robot_view.js";
import { SetupView } from "./setup_view.js";

export const VIEWS = [
    { id: "robot", tag: "panel-robot", View: RobotView },
    { id: "graphs", tag: "panel-graphs", View: GraphsView },
    { id: "setup", tag: "panel-setup", View: SetupView },
    { id: "motion", tag: "panel-motion", View: MotionView },
    { id: "packets", tag: "panel-packets", View: PacketsView },
    { id: "board", tag: "panel-board", View: BoardView },
];
