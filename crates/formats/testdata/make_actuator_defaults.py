"""Actuators with defaults of every other sort, as MuJoCo compiles them.

    python -m venv .venv && .venv/bin/pip install mujoco==4.0.0
    .venv/bin/python crates/formats/testdata/make_actuator_defaults.py

Written to testdata/reference/actuator_defaults.json: for each pair of defaults and actuator that MuJoCo accepts the law, with
numbers that its types do not use as zeros.
"""

import json
import pathlib

import mujoco

HERE = pathlib.Path(__file__).parent
DYNAMICS = ["none", "integrator", "filter", "filterexact", "muscle"]
CLASS = "<default class='c'>{}</default>"
DEFAULTS = [
    "<general/>",
    "<motor/>",
    "<general gainprm='7'/>",
    "<general gainprm='7' biasprm='1 2 3'/>",
    "<general biastype='affine' biasprm='1 2 -3'/>",
    "<general gaintype='affine' gainprm='1 2 -3'/>",
    "<general dyntype='filter' dynprm='.3'/>",
    "<general dyntype='filterexact' dynprm='.3'/>",
    "<general dyntype='integrator'/><position kp='3'/>",
    "<position kp='5' kv='2'/>",
    "<position kp='5' timeconst='.2'/>",
    "<position kp='5' dampratio='1'/>",
    "<position kp='5' inheritrange='.5'/>",
    "<position kp='5' kv='2'/><general/>",
    "<position kp='5' kv='2'/><motor/>",
    "<motor/><position kp='5' kv='2'/>",
    "<position kp='5' kv='2'/><velocity kv='3'/>",
    "<velocity kv='3'/><position kp='5' kv='2'/>",
    "<velocity kv='3'/>",
    "<velocity kv='3'/><general/>",
    "<intvelocity kp='4' kv='1'/>",
    "<intvelocity inheritrange='.5'/><general/>",
    "<cylinder area='2' bias='1 2 -3' timeconst='.3'/>",
    "<cylinder area='2' bias='1 2 -3'/><general/>",
    "<damper kv='2' ctrlrange='0 1'/>",
    "<damper kv='2' ctrlrange='0 1'/><general/>",
    "<muscle force='10' timeconst='.1 .2'/>",
    "<muscle force='10'/><general/>",
    "<adhesion gain='4' ctrlrange='0 1'/>",
    "<adhesion gain='4' ctrlrange='0 1'/><general/>",
    "<position kp='50' kv='5'/>" + CLASS.format("<general gear='2'/>"),
    "<position kp='50' kv='5'/>" + CLASS.format("<velocity kv='3'/>"),
    "<position kp='50' kv='5'/>" + CLASS.format("<velocity kv='3'/><general gaintype='affine'/>"),
    "<position kp='50' kv='5'/><general/>" + CLASS.format("<cylinder area='7'/>"),
]
ON_JOINT = ["position", "velocity", "intvelocity", "motor", "general", "cylinder"]
ACTUATORS = [f"<{sort} joint='j'/>" for sort in ON_JOINT] + [
    "<position joint='j' kp='11'/>",
    "<position joint='j' kv='3'/>",
    "<velocity joint='j' kv='11'/>",
    "<damper joint='j' ctrlrange='0 1'/>",
    "<muscle joint='j' lengthrange='0 1'/>",
    "<adhesion body='b' ctrlrange='0 1'/>",
]
MODEL = (
    "<mujoco><compiler angle='radian'/><default>{}</default><worldbody><body name='b'>"
    "<joint name='j' axis='0 1 0' range='-1 2'/><geom size='.1' pos='.3 0 0' mass='1'/></body></worldbody>"
    "<actuator>{}</actuator></mujoco>"
)


def law(xml):
    model = mujoco.MjModel.from_xml_string(xml)
    gain, bias = model.actuator_gainprm[0], model.actuator_biasprm[0]
    dynamics = DYNAMICS[model.actuator_dyntype[0]]
    own = {"dynamics": dynamics, "times": model.actuator_dynprm[0, :2].tolist()}
    if dynamics == "muscle":
        return own | {"gain": gain[:9].tolist(), "bias": bias[:9].tolist()}
    constant, none = model.actuator_gaintype[0] == 0, model.actuator_biastype[0] == 0
    limited, acts = model.actuator_ctrllimited[0], model.actuator_actlimited[0]
    return own | {
        "gain": [gain[0], 0.0, 0.0] if constant else gain[:3].tolist(),
        "bias": [0.0, 0.0, 0.0] if none else bias[:3].tolist(),
        "ctrlrange": model.actuator_ctrlrange[0].tolist() if limited else None,
        "actrange": model.actuator_actrange[0].tolist() if acts else None,
    }


def rows():
    for defaults in DEFAULTS:
        for actuator in ACTUATORS:
            if "class" in defaults:
                actuator = actuator.replace(" ", " class='c' ", 1)
            xml = MODEL.format(defaults, actuator)
            try:
                yield {"xml": xml} | law(xml)
            except ValueError:
                pass  # It refuses some, a range of a filter that is none of its own for one.


lines = ",\n".join(json.dumps(row) for row in rows())
(HERE / "reference/actuator_defaults.json").write_text(f"[\n{lines}\n]\n")
