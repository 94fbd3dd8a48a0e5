"""Records a run and writes it as one HTML page: run.rec, run.html."""

import signorini

TEXT = """<mujoco model="bouncing cubes">
  <option timestep="0.005"/>
  <worldbody>
    <geom type="plane" friction="0.5"/>
    <replicate count="4" offset="0.05 0.02 0.3" euler="10 20 30">
      <body name="cube" pos="0 0 0.4"><freejoint/><geom type="box" size="0.1 0.1 0.1" density="500" friction="0.5"/></body>
    </replicate>
  </worldbody>
</mujoco>"""

model = signorini.Model.from_string(TEXT)
data = signorini.Data(model)
with data.record("run.rec") as recorder:
    signorini.step(model, data, nstep=200)
recording = signorini.load_recording("run.rec")
print(recording)
print(f"contacts at most {recording.ncon.max()}, worst residual {recording.residuals.max():.0e}")
recording.to_html("run.html", notes=[("made by", "examples/report.py")])
