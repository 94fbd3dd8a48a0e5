-- A block is pushed over a floor with friction and slides to rest, from LuaJIT through the C header as it is:
--   luajit slide.lua include/signorini.h lib/libsignorini_c.so
-- Exits with an error unless it stops where Coulomb's law says.

local ffi = require("ffi")
local header_path, library_path = arg[1], arg[2]
assert(header_path and library_path, "usage: luajit slide.lua HEADER LIBRARY")

-- Structures and functions go to the foreign function interface; what the preprocessor would do is left out, its numbers become a table.
local constant, declarations = {}, {}
local inside_cplusplus = false
for line in io.lines(header_path) do
  local name, value = line:match("^#define%s+(SIGNORINI_%w[%w_]*)%s+(%-?%d+)%s*$")
  if name then constant[name] = tonumber(value) end
  if line:match("^#ifdef __cplusplus") then inside_cplusplus = true end
  if not inside_cplusplus and not line:match("^#") then table.insert(declarations, line) end
  if line:match("^#endif") then inside_cplusplus = false end
end
ffi.cdef(table.concat(declarations, "\n"))
local signorini = ffi.load(library_path)

local function check(status)
  if status < 0 then error(ffi.string(signorini.signorini_last_error()), 2) end
  return status
end

assert(signorini.signorini_abi_version() == constant.SIGNORINI_ABI_VERSION, "header and library do not fit")
local scene = [[<mujoco><option timestep="0.001" gravity="0 0 -10"/><worldbody>
  <geom name="floor" type="plane" friction="0.5"/>
  <body name="block" pos="0 0 0.1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="2" friction="0.5"/></body>
</worldbody></mujoco>]]
local place = ffi.new("signorini_model *[1]")
check(signorini.signorini_model_parse(scene, constant.SIGNORINI_MJCF, nil, nil, place))
local model = place[0]
place = ffi.new("signorini_simulation *[1]")
check(signorini.signorini_simulation_new(model, nil, place))
local simulation = place[0]
signorini.signorini_model_free(model) -- the simulation keeps what it needs

local speed, friction, gravity = 1.0, 0.5, 10.0
local q = ffi.new("double[7]", { 0, 0, 0.1, 1, 0, 0, 0 })
local v = ffi.new("double[6]", { speed, 0, 0, 0, 0, 0 })
check(signorini.signorini_set_state(simulation, q, 7, v, 6))
while math.abs(signorini.signorini_v(simulation)[0]) > 1e-9 do
  assert(check(signorini.signorini_step(simulation, 1)) == constant.SIGNORINI_OK, "a step missed its tolerance")
  assert(signorini.signorini_time(simulation) < 1, "it does not stop")
end

-- v²/(2 μ g), less half a step's way: the scheme moves with the velocity at the end of each step.
local expected = speed ^ 2 / (2 * friction * gravity) - speed * 0.001 / 2
local way, time = signorini.signorini_q(simulation)[0], signorini.signorini_time(simulation)
print(string.format("the block stops after %.3f s and %.6f m; Coulomb's law says %.3f s and %.6f m", time, way, speed / (friction * gravity), expected))
assert(math.abs(way - expected) < 1e-9 and math.abs(time - speed / (friction * gravity)) < 1.5e-3)
-- Not left to the garbage collector: at the end of a program it may unload the library before it frees what came from there.
signorini.signorini_simulation_free(simulation)
