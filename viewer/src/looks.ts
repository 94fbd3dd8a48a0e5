// Surfaces, light and sky as the pictures of `crates/render` have them (shade.rs): the same colours, lamps and tones.

import {
  BackSide, Color, CustomToneMapping, DirectionalLight, DoubleSide, FrontSide, Group, HemisphereLight, Light, Mesh, MeshPhongMaterial,
  Object3D, PointLight, RepeatWrapping, ShaderChunk, ShaderMaterial, SphereGeometry, SRGBColorSpace, Texture, Vector2,
  Vector3,
} from "three";
import type { WebGLRenderer } from "three";
import type { Checker, Geom, Header, Look } from "./data.js";
import type { Extent } from "./extent.js";

const PLAIN: Look = { group: 0, specular: 0.5, shininess: 0.5, emission: 0 };
/** Groups that are shown where nothing else is asked for. */
const SHOWN = 2;

export function lookOf(geom: Geom): Look {
  return geom.look ?? PLAIN;
}

/** Whether a geom is one of those that pictures show; the others are what only touches. */
export function isShown(geom: Geom): boolean {
  return lookOf(geom).group <= SHOWN && (geom.rgba?.[3] ?? 1) > 1e-3;
}

/** Linear RGB. */
const HORIZON = new Vector3(0.86, 0.9, 0.94);
const ZENITH = new Vector3(0.42, 0.58, 0.8);
const SKY_LIGHT = new Color().setRGB(0.4, 0.41, 0.44, "srgb-linear");
const GROUND_LIGHT = new Color().setRGB(0.19, 0.18, 0.17, "srgb-linear");
const SUNS: [Vector3, number, boolean][] = [
  [new Vector3(0.25, -0.55, 0.8).normalize(), 0.75, true],
  [new Vector3(-0.6, -0.3, 0.5).normalize(), 0.16, false],
];
const HEADLIGHT = 0.3;
/** Sum of the brightness of a model's lamps. */
const LAMPS = 0.9;

/** Bright light ends in a shoulder as film has it, and keeps its hue. */
export function setTones(renderer: WebGLRenderer): void {
  ShaderChunk.tonemapping_pars_fragment = ShaderChunk.tonemapping_pars_fragment.replace(
    "vec3 CustomToneMapping( vec3 color ) { return color; }",
    `vec3 CustomToneMapping( vec3 color ) {
      float peak = max(color.r, max(color.g, color.b));
      return peak > 0.8 ? color * ((1.0 - 0.04 / (peak - 0.6)) / peak) : color;
    }`,
  );
  renderer.toneMapping = CustomToneMapping;
}

/** The sky: what is behind everything. */
export function sky(): Mesh {
  const material = new ShaderMaterial({
    side: BackSide,
    depthTest: false,
    depthWrite: false,
    uniforms: { horizon: { value: HORIZON }, zenith: { value: ZENITH } },
    vertexShader: `
      varying vec3 direction;
      void main() {
        direction = position;
        vec4 place = projectionMatrix * vec4(mat3(viewMatrix) * position, 1.0);
        gl_Position = place.xyww;
      }`,
    fragmentShader: `
      uniform vec3 horizon;
      uniform vec3 zenith;
      varying vec3 direction;
      void main() {
        float up = max(normalize(direction).z, 0.0);
        gl_FragColor = vec4(mix(horizon, zenith, pow(up, 0.7)), 1.0);
        #include <tonemapping_fragment>
        #include <colorspace_fragment>
      }`,
  });
  const dome = new Mesh(new SphereGeometry(1, 32, 16), material);
  dome.frustumCulled = false;
  dome.renderOrder = -10;
  return dome;
}

/** The colour of squares averaged over a pixel (Quilez, "Filtering the checkerboard pattern"). */
const SQUARES = `
uniform vec3 squareColors[2];
uniform vec2 squareSides;
varying vec2 squarePlace;
vec2 squareWave(vec2 x, vec2 w) {
  vec2 a = 2.0 * abs(mod(0.5 * (x - 0.5 * w), 1.0) - 0.5);
  vec2 b = 2.0 * abs(mod(0.5 * (x + 0.5 * w), 1.0) - 0.5);
  return (a - b) / w;
}
vec3 squares() {
  vec2 x = squarePlace / squareSides;
  float pixel = max(length(dFdx(squarePlace)), length(dFdy(squarePlace)));
  vec2 wave = squareWave(x, max(vec2(pixel) / squareSides, vec2(1e-6)));
  return mix(squareColors[0], squareColors[1], clamp(0.5 - 0.5 * wave.x * wave.y, 0.0, 1.0));
}`;

/** What is far from everything fades into the sky. */
const AIR = `
float airFar = length(vViewPosition) / airReach;
vec3 airDirection = normalize(transpose(mat3(viewMatrix)) * -vViewPosition);
vec3 airBehind = mix(airHorizon, airZenith, pow(max(airDirection.z, 0.0), 0.7));
outgoingLight = mix(outgoingLight, airBehind, 1.0 - exp(-airFar * airFar));
#include <opaque_fragment>`;

/** The surface of a geom. */
export function materialOf(geom: Geom, images: Texture[], checker: Checker | undefined, extent: Extent): MeshPhongMaterial {
  const look = lookOf(geom);
  const shininess = 4 + 124 * look.shininess;
  // Of the normalised lobe the renderer's strength.
  const specular = Math.min((1.4 * look.specular) / (shininess / 2 + 1), 1);
  // Files do not care which way triangles look, and what one looks through has a far side.
  const open = ["mesh", "height_field", "plane"].includes(geom.shape.type) || (geom.rgba?.[3] ?? 1) < 0.99;
  const map = look.texture ? images[look.texture.image] : null;
  const material = new MeshPhongMaterial({ shininess, map, side: open ? DoubleSide : FrontSide, forceSinglePass: false });
  material.specular.setRGB(specular, specular, specular, "srgb-linear");
  const linear = (color: number[]) => new Color().setRGB(color[0], color[1], color[2], "srgb");
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, {
      airReach: { value: 30 * extent.length },
      airHorizon: { value: HORIZON },
      airZenith: { value: ZENITH },
    });
    const air = "uniform float airReach;\nuniform vec3 airHorizon;\nuniform vec3 airZenith;\n";
    shader.fragmentShader = air + shader.fragmentShader.replace("#include <opaque_fragment>", AIR);
    if (!checker) return;
    Object.assign(shader.uniforms, {
      squareColors: { value: checker.colors.map(linear) },
      squareSides: { value: new Vector2(...checker.square) },
    });
    shader.vertexShader = `varying vec2 squarePlace;\n${shader.vertexShader}`
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nsquarePlace = position.xy;");
    shader.fragmentShader = SQUARES + shader.fragmentShader
      .replace("#include <map_fragment>", "#include <map_fragment>\ndiffuseColor.rgb *= squares();");
  };
  material.customProgramCacheKey = () => (checker ? "squares" : "plain");
  return material;
}

/** The images of a page. */
export function readImages(header: Header): Promise<Texture[]> {
  return Promise.all((header.images ?? []).map(async (base64) => {
    const image = new Image();
    image.src = `data:image/jpeg;base64,${base64}`;
    await image.decode();
    const texture = new Texture(image);
    texture.colorSpace = SRGBColorSpace;
    texture.wrapS = texture.wrapT = RepeatWrapping;
    texture.anisotropy = 4;
    texture.needsUpdate = true;
    return texture;
  }));
}

/** Light from everywhere, the model's lamps or two suns, and where there are lamps one at the camera. */
export function lightsOf(header: Header, bodies: Group[], camera: Object3D, extent: Extent): { scene: Object3D[]; suns: DirectionalLight[] } {
  const everywhere = new HemisphereLight(SKY_LIGHT, GROUND_LIGHT, Math.PI);
  everywhere.position.set(0, 0, 1);
  const lamps = header.lights ?? [];
  const suns: DirectionalLight[] = [];
  const sun = (toward: Vector3, color: Color, shadows: boolean): DirectionalLight => {
    const light = new DirectionalLight(color, Math.PI);
    light.target.position.copy(extent.centre);
    light.position.copy(extent.centre).addScaledVector(toward, 5 * extent.radius);
    if (shadows) castShadows(light, extent);
    suns.push(light);
    return light;
  };
  if (lamps.length === 0) {
    const scene = SUNS.flatMap(([toward, strength, shadows]) => {
      const light = sun(toward, new Color().setRGB(strength, strength, strength, "srgb-linear"), shadows);
      return [light, light.target];
    });
    return { scene: [everywhere, ...scene], suns };
  }
  const total = lamps.reduce((sum, { color }) => sum + (color[0] + color[1] + color[2]) / 3, 0);
  const scale = total > 0 ? LAMPS / total : 0;
  const scene: Object3D[] = [everywhere];
  for (const { body, position, direction, directional, color, shadows } of lamps) {
    const strength = new Color().setRGB(scale * color[0], scale * color[1], scale * color[2], "srgb-linear");
    if (directional) {
      const light = sun(new Vector3(...direction).negate().normalize(), strength, shadows);
      scene.push(light, light.target);
    } else {
      const light = new PointLight(strength, Math.PI, 0, 0);
      light.position.set(...position);
      light.castShadow = shadows;
      light.shadow.mapSize.set(1024, 1024);
      light.shadow.normalBias = 0.004 * extent.radius;
      bodies[body].add(light);
    }
  }
  const head: Light = new PointLight(0xffffff, HEADLIGHT * Math.PI, 0, 0);
  camera.add(head);
  scene.push(camera);
  return { scene, suns };
}

function castShadows(light: DirectionalLight, { radius }: Extent): void {
  const reach = 1.5 * radius;
  light.castShadow = true;
  light.shadow.mapSize.set(2048, 2048);
  light.shadow.radius = 1.5;
  light.shadow.normalBias = 0.004 * radius;
  Object.assign(light.shadow.camera, {
    left: -reach, right: reach, bottom: -reach, top: reach, near: 0.1 * radius, far: 12 * radius,
  });
}
