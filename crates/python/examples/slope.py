"""A box on a slope: below the friction angle it does not creep, above it slides as Coulomb says."""

import numpy as np

import signorini

TEXT = """<mujoco model="slope">
  <worldbody>
    <geom name="slope" type="plane" euler="0 20 0" friction="{friction}"/>
    <body name="box" pos="0 0 0" euler="0 20 0">
      <freejoint/>
      <geom type="box" size="0.1 0.1 0.1" pos="0 0 0.1" mass="1" friction="{friction}"/>
    </body>
  </worldbody>
</mujoco>"""

angle = np.radians(20)
for friction in (0.5, 0.2):
    model = signorini.Model.from_string(TEXT.format(friction=friction))
    data = signorini.Data(model)
    signorini.step(model, data, nstep=500)
    along = np.linalg.norm(data.body("box").xpos)
    expected = 0.5 * max(0.0, 9.81 * (np.sin(angle) - friction * np.cos(angle))) * data.time**2
    modes = sorted({signorini.ContactMode(m).name for m in data.contact.mode})
    print(f"friction {friction}: moved {along:.3g} m in {data.time:.0f} s (expected {expected:.3g}), contacts {modes},")
    print(f"    force on the box {np.round(data.contact.force_world.sum(axis=0), 6)} N, worst residual {data.certificate.worst:.0e}")
