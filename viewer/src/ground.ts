// Planes: a grid that fades with distance and catches shadows.

import {
  Color, DoubleSide, Group, Mesh, PlaneGeometry, ShaderMaterial, ShadowMaterial, Vector2,
} from "three";
import type { Theme } from "./theme.js";

const VERTEX = `
varying vec2 place;
void main() {
  place = position.xy;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const FRAGMENT = `
uniform vec3 ground;
uniform vec3 grid;
uniform float spacing;
uniform float reach;
uniform vec2 centre;
varying vec2 place;

float lines(vec2 p, float width) {
  vec2 slope = fwidth(p);
  vec2 distance = abs(fract(p - 0.5) - 0.5) / slope;
  float line = 1.0 - clamp(min(distance.x, distance.y) - width, 0.0, 1.0);
  return line * (1.0 - smoothstep(0.15, 0.5, max(slope.x, slope.y)));
}

void main() {
  float fade = 1.0 - smoothstep(0.25, 1.0, length(place - centre) / reach);
  float line = max(0.28 * lines(place / spacing, 0.0), 0.7 * lines(place / (5.0 * spacing), 0.2));
  gl_FragColor = vec4(mix(ground, grid, line), fade);
  #include <colorspace_fragment>
}`;

/** The plane z = 0 of its frame, drawn around a centre. */
export class Ground extends Group {
  private readonly paint: ShaderMaterial;
  private readonly shade = new ShadowMaterial({ opacity: 0.2 });

  constructor(sceneRadius: number, centre: [number, number]) {
    super();
    const reach = 7 * sceneRadius;
    const spacing = 10 ** Math.floor(Math.log10(sceneRadius * 0.9)) * (sceneRadius < 0.5 ? 0.5 : 1);
    this.paint = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      side: DoubleSide,
      transparent: true,
      depthWrite: false,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
      uniforms: {
        ground: { value: new Color() },
        grid: { value: new Color() },
        spacing: { value: spacing },
        reach: { value: reach },
        centre: { value: new Vector2(...centre) },
      },
    });
    const geometry = new PlaneGeometry(2 * reach, 2 * reach).translate(centre[0], centre[1], 0);
    const painted = new Mesh(geometry, this.paint);
    painted.renderOrder = -2;
    const shaded = new Mesh(geometry, this.shade);
    shaded.receiveShadow = true;
    shaded.renderOrder = -1;
    this.shade.depthWrite = false;
    this.add(painted, shaded);
  }

  setTheme(theme: Theme): void {
    this.paint.uniforms.ground.value.set(theme.ground);
    this.paint.uniforms.grid.value.set(theme.grid);
    this.shade.opacity = theme.dark ? 0.45 : 0.2;
  }
}
