"""Whether models survive being edited and written: file → Spec → MJCF → Model, compared with the file's model.

    python3 benchmarks/robots/round_trip.py FOLDER ... [--every N] [--only REGEX] [--patience 20]

At five configurations, drawn between the limits of the joints, the mass matrix, the bias forces, all sensors of the state and the contact
points of the model that was written and read again are those of the model itself, to 1e-12 of the largest number of their sort. Every file
has a process of its own. Needs the Python package `signorini`.
"""

import argparse
import collections
import multiprocessing
import pathlib
import re
import sys

import models

TOLERANCE = 1e-12
CONFIGURATIONS = 5


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=pathlib.Path)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--only", type=re.compile)
    parser.add_argument("--patience", type=float, default=20.0)
    arguments = parser.parse_args()
    found = [model for model in models.find(arguments.folders) if not model.missing and not model.empty]
    chosen = [model.path for model in found if not arguments.only or arguments.only.search(str(model.path))]
    outcomes = collections.Counter()
    for path in chosen[:: arguments.every]:
        outcome = in_a_process(path, arguments.patience)
        outcomes[outcome.split(":")[0]] += 1
        if outcome != "the same":
            print(f"{path}: {outcome}", flush=True)
    print(", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common()))
    if set(outcomes) - {"the same", "not read"}:
        sys.exit(1)


def in_a_process(path, patience):
    here, there = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.Process(target=lambda: there.send(guarded(path)), daemon=True)
    process.start()
    outcome = here.recv() if here.poll(patience) else "out of patience"
    process.kill()
    process.join()
    return outcome


def guarded(path):
    try:
        return compare(path)
    except Exception as error:
        return f"stopped: {str(error).splitlines()[0]}"


def compare(path):
    import warnings

    import signorini

    warnings.simplefilter("ignore")
    try:
        model = signorini.Model.from_file(path)
    except Exception as error:
        return f"not read: {str(error).splitlines()[0]}"
    try:
        text, left_out = signorini.Spec(model).to_mjcf()
        again = signorini.Model.from_string(text)
    except Exception as error:
        return f"not written: {str(error).splitlines()[0]}"
    worst = differences(signorini, model, again)
    wrong = {what: size for what, size in worst.items() if not size <= TOLERANCE}
    if not wrong:
        return "the same"
    return f"other: {wrong} (said: {left_out[:3]})"


def differences(signorini, model, again):
    """The largest difference of every sort of numbers, relative to the largest of them."""
    import numpy as np

    if (model.nq, model.nv, model.nu, model.na) != (again.nq, again.nv, again.nu, again.na):
        return {"sizes": float("inf")}
    random, worst = np.random.default_rng(0), collections.Counter()
    data, other = signorini.Data(model), signorini.Data(again)
    start, data.qvel = np.array(data.qpos), random.normal(size=model.nv)
    if not np.allclose(start, other.qpos, rtol=0, atol=1e-15):
        return {"reference": float(np.max(np.abs(start - other.qpos)))}
    other.qvel = data.qvel
    for k in range(CONFIGURATIONS):
        data.qpos = other.qpos = configuration(model, start, random) if k else start
        signorini.forward(model, data)
        signorini.forward(again, other)
        pairs = {
            "mass matrix": [signorini.mass_matrix(model, data), signorini.mass_matrix(again, other)],
            "bias": [signorini.bias_force(model, data), signorini.bias_force(again, other)],
            "sensors": [np.array(data.sensordata), np.array(other.sensordata)],
            "contacts": [contacts(signorini, model, data), contacts(signorini, again, other)],
        }
        for what, (own, new) in pairs.items():
            size = float("inf") if own.shape != new.shape else np.max(np.abs(own - new), initial=0.0)
            worst[what] = max(worst[what], size / max(1.0, np.max(np.abs(own), initial=0.0)))
    return worst


def configuration(model, start, random):
    """Hinges and slides anywhere between their limits, what floats and turns freely where it was."""
    import numpy as np

    q = np.array(start)
    for k in range(model.njnt):
        joint = model.joint(k)
        if joint.nq == 1:
            low, high = joint.range if joint.range is not None else (-1.0, 1.0)
            q[joint.qposadr] = random.uniform(low, high)
    return q


def contacts(signorini, model, data):
    import numpy as np

    found = signorini.contacts_at(model, data)
    rows = [np.concatenate([[point.gap, point.friction], point.point, point.normal]) for point in found]
    return np.array(rows).reshape(len(rows), 8)


if __name__ == "__main__":
    main()
