"""The commands of `eyehand`: where each one is, its former names, and the extras it needs."""

from __future__ import annotations

COMMANDS: dict[str, tuple[str, str]] = {
    "demo": ("eyehand.apps.demo:demo", "clear a table of unknown objects with a simulated robot"),
    "perceive": (
        "eyehand.apps.perceive:perceive_command",
        "describe a depth frame, a recording or a live camera",
    ),
    "grasp": (
        "eyehand.apps.grasp_command:grasp_command",
        "rank the grasps of a parallel gripper in a depth frame",
    ),
    "hand describe": (
        "eyehand.apps.hand_describe:hand_describe",
        "describe the gripper of an MJCF or URDF file for eyehand grasp",
    ),
    "calibrate": (
        "eyehand.apps.calibrate:calibrate_command",
        "find where a camera is mounted, from images of a board at several robot poses",
    ),
    "fit": ("eyehand.apps.fit:fit_command", "fit the simplest solid to point clouds and meshes"),
    "doctor": (
        "eyehand.apps.doctor:doctor_command",
        "report what works on this machine, and what to install for the rest",
    ),
    "synth": ("eyehand.apps.synth:synth", "make a synthetic depth frame with its ground truth"),
    "evaluate segmentation": (
        "eyehand.apps.segmentation.evaluate:evaluate_segmentation",
        "score the segmentation on labelled or synthetic frames",
    ),
    "evaluate fit": (
        "eyehand.apps.fitting.bench.evaluate:evaluate_fit",
        "fit clouds or scanned objects with known shape, and report the overlap",
    ),
    "evaluate motion": (
        "eyehand.apps.motion.evaluate:evaluate_motion",
        "reach goals among obstacles: success, contacts, time per cycle",
    ),
    "evaluate grasp": (
        "eyehand.apps.grasp.bench.evaluate:evaluate_grasp",
        "clear simulated tables of unknown objects: success, objects put away, times",
    ),
    "chart segmentation": (
        "eyehand.apps.segmentation.chart:chart_segmentation",
        "chart the segmentation's time against its accuracy, beside baselines",
    ),
    "chart fit": (
        "eyehand.apps.fitting.bench.chart:chart_fit",
        "chart the fit's time against its accuracy, beside baselines",
    ),
    "chart grasp": (
        "eyehand.apps.grasp.bench.chart:chart_grasp",
        "chart the time per pick against its success for each setting",
    ),
    "stress segmentation": (
        "eyehand.apps.segmentation.stress:stress_segmentation",
        "make generated scenes harder until the segmentation breaks, and chart where",
    ),
    "stress fit": (
        "eyehand.apps.fitting.bench.stress:stress_fit",
        "make clouds harder until the fit breaks, and chart where",
    ),
    "stress motion": (
        "eyehand.apps.motion.stress:stress_motion",
        "make motions of an arm harder until the controller breaks, and chart where",
    ),
    "stress touch": (
        "eyehand.apps.touch.stress:stress_touch",
        "make contacts harder until the tactile servo breaks, and chart where",
    ),
    "stress grasp": (
        "eyehand.apps.grasp.bench.stress:stress_grasp",
        "make picks harder until they break, and chart where",
    ),
    "touch view": (
        "eyehand.apps.touch.view:touch_view",
        "show a tactile sensor or a recording live in the browser, and record it",
    ),
    "experiment fig1": (
        "eyehand.apps.motion.fig1:experiment_fig1",
        "Fig. 1: the path of a hand around obstacles, by the weight of avoidance",
    ),
    "experiment force-closure": (
        "eyehand.apps.grasp.force_closure:experiment_force_closure",
        "section 2: improve a grasp after contact, by null-space motions of the arm",
    ),
    "experiment features": (
        "eyehand.apps.touch.features:experiment_features",
        "section 3.2: methods for a contact's orientation and position, time against accuracy",
    ),
    "experiment slip": (
        "eyehand.apps.touch.slip:experiment_slip",
        "section 3.1: detect slip of unseen objects, simulated or recorded",
    ),
    "experiment grip": (
        "eyehand.apps.touch.grip:experiment_grip",
        "section 3.1: hold unknown objects with little force, by slip and by estimated friction",
    ),
    "experiment cop": (
        "eyehand.apps.touch.cop:experiment_cop",
        "Fig. 5: the centre of pressure of a thin probe between tactels",
    ),
    "experiment track": (
        "eyehand.apps.touch.track:experiment_track",
        "Table 1, Fig. 8: hold a contact's position and pressure on hard and soft objects",
    ),
    "experiment roll": (
        "eyehand.apps.touch.roll:experiment_roll",
        "Fig. 9: roll a tilted pad flat onto a face, and follow the face when it turns",
    ),
    "experiment edge": (
        "eyehand.apps.touch.edge:experiment_edge",
        "section 4.3: turn the pad with an object's edge",
    ),
    "experiment cable": (
        "eyehand.apps.touch.cable:experiment_cable",
        "Fig. 10: follow cables of unknown shape along a table",
    ),
    "experiment explore": (
        "eyehand.apps.touch.explore:experiment_explore",
        "Fig. 11: scan an unknown object with two pads on two arms, and write its point cloud",
    ),
    "experiment seek": (
        "eyehand.apps.touch.seek:experiment_seek",
        "section 5: find ridges, edges and corners of unknown objects by touch",
    ),
}
"""Command name → (module:function, one-line help)."""

ALIASES: dict[str, str] = {
    "evaluate touch": "experiment track",
    "chart motion": "evaluate motion",
    "chart touch": "experiment features",
}
"""Second name → command, so that every stage can be evaluated and charted under its own name."""

GROUPS: dict[str, str] = {
    "hand": "describe grippers",
    "evaluate": "measure a stage against known truth",
    "chart": "chart a stage's speed against its accuracy",
    "stress": "make a stage's task harder until it breaks, and chart where",
    "touch": "show the readings of a tactile sensor",
    "experiment": "run a figure, table or section of the chapter",
}
"""First word of a two-word command → one-line help."""

RENAMED: dict[str, str] = {
    "control fig1": "experiment fig1",
    "control bench": "evaluate motion",
    "control stress": "stress motion",
    "control": "evaluate motion, stress motion or experiment fig1",
    "touch stress": "stress touch",
    **{
        f"touch {name}": f"experiment {name}"
        for name in ("features", "cop", "track", "roll", "edge", "cable", "seek", "explore")
    },
}
"""Former command → what it is called now."""

EXTRAS: dict[str, str] = {
    "OpenGL": "sim",
    "imageio_ffmpeg": "view",
    "matplotlib": "view",
    "pyvista": "view",
    "viser": "view",
    "vtkmodules": "view",
    "depthai": "oak",
    "gymnasium_robotics": "robots",
    "mujoco_menagerie": "robots",
    "mcap": "ros",
    "mcap_ros2": "ros",
    "distributed": "cluster",
    "mink": "baselines",
    "open3d": "baselines",
    "skimage": "baselines",
}
"""Module that the core install leaves out → the extra that installs it."""

NEEDED: dict[str, tuple[str, ...]] = {
    "demo": ("matplotlib", "imageio_ffmpeg"),
    "evaluate": ("matplotlib",),
    "chart": ("matplotlib",),
    "stress": ("matplotlib",),
    "touch": ("viser",),
    "experiment": ("matplotlib",),
}
"""Command or group → modules of extras that it needs, checked before it starts to work."""
