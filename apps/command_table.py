"""The commands of `eyehand`: where each one is, its former names, and the extras it needs."""

from __future__ import annotations

COMMANDS: dict[str, tuple[str, str]] = {
    name: (f"eyehand.apps.{place if ':' in place else place + ':' + name.replace(' ', '_')}", line)
    for name, place, line in (
        ("demo", "demo", "clear a table of unknown objects with a simulated robot"),
        ("perceive", "perceive:perceive_command",
         "describe a depth frame, a recording or a live camera"),
        ("grasp", "grasp_command:grasp_command",
         "rank the grasps of a parallel gripper in a depth frame"),
        ("hand describe", "hand_describe",
         "describe the gripper of an MJCF or URDF file for eyehand grasp"),
        ("calibrate", "calibrate:calibrate_command",
         "find where a camera is mounted, from images of a board at several robot poses"),
        ("fit", "fit:fit_command", "fit the simplest solid to point clouds and meshes"),
        ("doctor", "doctor:doctor_command",
         "report what works on this machine, and what to install for the rest"),
        ("synth", "synth", "make a synthetic depth frame with its ground truth"),
        ("evaluate segmentation", "segmentation.evaluate",
         "score the segmentation on labelled or synthetic frames"),
        ("evaluate fit", "fitting.bench.evaluate",
         "fit clouds or scanned objects with known shape, and report the overlap"),
        ("evaluate motion", "motion.evaluate",
         "reach goals among obstacles: success, contacts, time per cycle"),
        ("evaluate grasp", "grasp.bench.evaluate",
         "clear simulated tables of unknown objects: success, objects put away, times"),
        ("chart segmentation", "segmentation.chart",
         "chart the segmentation's time against its accuracy, beside baselines"),
        ("chart fit", "fitting.bench.chart",
         "chart the fit's time against its accuracy, beside baselines"),
        ("chart grasp", "grasp.bench.chart",
         "chart the time per pick against its success for each setting"),
        ("stress segmentation", "segmentation.stress",
         "make generated scenes harder until the segmentation breaks, and chart where"),
        ("stress fit", "fitting.bench.stress",
         "make clouds harder until the fit breaks, and chart where"),
        ("stress motion", "motion.stress",
         "make motions of an arm harder until the controller breaks, and chart where"),
        ("stress touch", "touch.stress",
         "make contacts harder until the tactile servo breaks, and chart where"),
        ("stress grasp", "grasp.bench.stress",
         "make picks harder until they break, and chart where"),
        ("touch view", "touch.view",
         "show a tactile sensor or a recording live in the browser, and record it"),
        ("experiment fig1", "motion.fig1",
         "Fig. 1: the path of a hand around obstacles, by the weight of avoidance"),
        ("experiment features", "touch.features",
         "section 3.2: methods for a contact's orientation and position, time against accuracy"),
        ("experiment slip", "touch.slip",
         "section 3.1: detect slip of unseen objects, simulated or recorded"),
        ("experiment grip", "touch.grip",
         "section 3.1: hold unknown objects with little force, by slip and by estimated friction"),
        ("experiment cop", "touch.cop",
         "Fig. 5: the centre of pressure of a thin probe between tactels"),
        ("experiment track", "touch.track",
         "Table 1, Fig. 8: hold a contact's position and pressure on hard and soft objects"),
        ("experiment roll", "touch.roll",
         "Fig. 9: roll a tilted pad flat onto a face, and follow the face when it turns"),
        ("experiment edge", "touch.edge", "section 4.3: turn the pad with an object's edge"),
        ("experiment cable", "touch.cable",
         "Fig. 10: follow cables of unknown shape along a table"),
        ("experiment explore", "touch.explore",
         "Fig. 11: scan an unknown object with two pads on two arms, and write its point cloud"),
        ("experiment seek", "touch.seek",
         "section 5: find ridges, edges and corners of unknown objects by touch"),
    )
}  # fmt: skip
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
    module: extra
    for extra, modules in {
        "sim": ("OpenGL",),
        "view": ("imageio_ffmpeg", "matplotlib", "pyvista", "viser", "vtkmodules"),
        "oak": ("depthai",),
        "robots": ("gymnasium_robotics", "mujoco_menagerie"),
        "ros": ("mcap", "mcap_ros2"),
        "cluster": ("distributed",),
        "baselines": ("mink", "open3d", "skimage"),
    }.items()
    for module in modules
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
