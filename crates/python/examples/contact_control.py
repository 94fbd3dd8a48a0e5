"""Contact-implicit control: choose the push on a box with the linear complementarity system of its step.

The box rests on a rough floor. A push below the friction bound does nothing, so the derivative of the motion with respect to the
push is zero there and says nothing; the complementarity system knows at which push the box begins to slide.
"""

import numpy as np

import signorini

TEXT = """<mujoco model="push">
  <option timestep="0.01"/>
  <worldbody>
    <geom type="plane" friction="0.5"/>
    <body name="box" pos="0 0 0.1">
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="z" type="slide" axis="0 0 1"/>
      <geom type="box" size="0.1 0.1 0.1" mass="2" friction="0.5"/>
    </body>
  </worldbody>
  <actuator><motor name="push" joint="x"/></actuator>
</mujoco>"""

model = signorini.Model.from_string(TEXT)
data = signorini.Data(model)
signorini.step(model, data, nstep=10)
system = signorini.linearize(model, data)
print("friction bound:", 0.5 * 2 * 9.81, "N")
target = 0.05
pushes = np.linspace(0, 25, 51)
speeds = [system.step(u=[push])[0][2] for push in pushes]
best = float(pushes[np.argmin(np.abs(np.array(speeds) - target))])
data.actuator("push").ctrl = best
signorini.step(model, data)
print(f"wanted {target} m/s, chose {best} N, got {data.joint('x').qvel[0]:.3f} m/s")
