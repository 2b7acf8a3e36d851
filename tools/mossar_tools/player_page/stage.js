// The stage: a picture with the skeleton that was estimated from it, or a figure in its place.

const NEAR = 12; // degrees, from which a bone that strays gets colour,
const FAR = 30; // and from which it has all of it
const EYE = 1.1; // m above the ground
const AWAY = 5; // m from the figure
const ROOM = { left: -0.75, right: 0.75, low: -0.1, high: 2.02 }; // m that are always in view
const [THICK, THIN] = [1.15, 0.8]; // of a limb's mean radius, at its start and at its end
const BACK = 0.995; // share of the rest that is kept in view from picture to picture
const MARGIN = 0.06; // of a picture's width, beside the people in it
const LEAST = 0.45; // of a picture's width that is always shown
const PACE = 0.12; // share of the way to another part of the picture, from picture to picture
const CALM = [79, 195, 247]; // on pictures
const STRAYS = [255, 98, 0];

function mixed(one, other, share) {
  return one.map((value, k) => Math.round(value + share * (other[k] - value)));
}

function css(colour, alpha = 1) {
  return `rgb(${colour.join(" ")} / ${alpha})`;
}

// How much of the colour a bone gets that strays: none, or enough of it to be seen from afar.
function straying(angle) {
  if (angle === null || angle === undefined || angle < NEAR) return 0;
  return Math.min(1, 0.6 + (0.4 * (angle - NEAR)) / (FAR - NEAR));
}

function rgb(text) {
  return [1, 3, 5].map((place) => parseInt(text.trim().slice(place, place + 2), 16));
}

export class Stage {
  constructor(canvas, mirrored) {
    Object.assign(this, { canvas, mirrored, room: { ...ROOM }, part: [0, 1] });
    this.pen = canvas.getContext("2d");
    this.paint();
  }

  // Reads the colours of the style sheet, after they have changed.
  paint() {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => rgb(style.getPropertyValue(`--${name}`));
    this.colours = { stage: colour("stage"), spot: colour("spot"), body: colour("body"), off: colour("off"), example: colour("ring") };
  }

  // Returns width and height in pixels of the screen.
  fit() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const size = [this.canvas.clientWidth, this.canvas.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    if (this.canvas.width !== size[0] || this.canvas.height !== size[1]) [this.canvas.width, this.canvas.height] = size;
    return size;
  }

  // The picture, as large as there is room, and the people in it: points are shares of its width and height. Where the
  // stage is narrower than the picture, the sides are left out that nobody is in; no joint is.
  showPicture(picture, people, outline, strays) {
    const [width, height] = this.fit();
    const { pen } = this;
    const [begin, end] = this.window(people, (width / height) * (picture.height / picture.width));
    const scale = Math.min(width / ((end - begin) * picture.width), height / picture.height);
    const across = picture.width * scale;
    const down = picture.height * scale;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.fillStyle = css(this.colours.stage);
    pen.fillRect(0, 0, width, height);
    if (this.mirrored) pen.setTransform(-1, 0, 0, 1, width, 0);
    pen.translate(width / 2 - ((begin + end) / 2) * across, (height - down) / 2);
    pen.drawImage(picture, 0, 0, across, down);
    for (const points of people) this.drawLines(points.map((point) => point && [point[0] * across, point[1] * down]), outline, strays, down);
  }

  // Which part of a picture is shown, as shares of its width: as much as the stage has room for, and all people.
  window(people, room) {
    const places = people.flat().filter(Boolean).map(([x]) => x);
    let wanted = [0, 1];
    if (places.length && room < 1) {
      const [first, last] = [Math.min(...places) - MARGIN, Math.max(...places) + MARGIN];
      const wide = Math.min(1, Math.max(room, last - first, LEAST));
      const begin = Math.min(1 - wide, Math.max(0, (first + last - wide) / 2));
      wanted = [begin, begin + wide];
    }
    this.part = this.part.map((side, k) => side + PACE * (wanted[k] - side));
    const [first, last] = [Math.min(this.part[0], ...places), Math.max(this.part[1], ...places)];
    return [Math.max(0, first), Math.min(1, last)];
  }

  drawLines(points, { bones, trunk, head, back }, strays, down) {
    const { pen } = this;
    const wide = Math.max(3, down / 110);
    pen.lineCap = pen.lineJoin = "round";
    const corners = trunk.map((place) => points[place]);
    const lines = corners.every(Boolean) && corners.length ? [[[...corners, corners[0]], straying(strays?.[back])]] : [];
    bones.forEach(([a, b], k) => {
      if (points[a] && points[b] && b !== head && !(k === back && lines.length)) lines.push([[points[a], points[b]], straying(strays?.[k])]);
    });
    for (const [line, share] of lines.sort((one, other) => one[1] - other[1])) {
      pen.beginPath();
      for (const point of line) pen.lineTo(...point);
      for (const [colour, width] of [[[0, 0, 0, 0.55], wide * 1.7], [null, wide * (1 + 0.6 * share)]]) {
        pen.strokeStyle = colour ? css(colour.slice(0, 3), colour[3]) : css(mixed(CALM, STRAYS, share));
        pen.lineWidth = width;
        pen.stroke();
      }
    }
    pen.fillStyle = "#fff";
    points.forEach((point, place) => {
      if (!point || place === head) return;
      pen.beginPath();
      pen.arc(...point, wide * 0.75, 0, 7);
      pen.fill();
    });
  }

  // A figure on lit ground, the whole of it in view; points are mm: to the right, away, up.
  showFigure(person) {
    const [width, height] = this.fit();
    const { pen, colours } = this;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    const points = person?.points?.map((point) => point && point.map((value) => value / 1000)) ?? null;
    if (points) this.keepInView(points);
    const { left, right, low, high } = this.room;
    const scale = Math.min(width / (right - left), height / (high - low));
    const middle = width / 2 - ((left + right) / 2) * scale;
    const ground = height / 2 + ((low + high) / 2) * scale;
    this.drawGround(width, height, middle, ground, scale);
    if (!points) return;
    if (this.mirrored) {
      pen.setTransform(-1, 0, 0, 1, width, 0);
    }
    const place = ([x, y, z]) => {
      const near = AWAY / (AWAY + y);
      return [middle + x * near * scale, ground - (EYE + (z - EYE) * near) * scale, near * scale, y];
    };
    this.drawShadow(points, place);
    const example = person.example;
    if (example?.points) {
      const over = example.points.map((point) => point && place(point.map((value) => value / 1000)));
      this.drawBody(over, example, null, points, { flat: css(colours.example, 0.28), wider: 1.3 });
    }
    this.drawBody(points.map((point) => point && place(point)), person.outline, person.strays, points, {});
  }

  keepInView(points) {
    const { room } = this;
    for (const side of Object.keys(ROOM)) room[side] = ROOM[side] + BACK * (room[side] - ROOM[side]);
    for (const point of points) {
      if (!point) continue;
      const near = AWAY / (AWAY + point[1]);
      const [x, z] = [point[0] * near, EYE + (point[2] - EYE) * near];
      room.left = Math.min(room.left, x - 0.2);
      room.right = Math.max(room.right, x + 0.2);
      room.low = Math.min(room.low, z - 0.12);
      room.high = Math.max(room.high, z + 0.2);
    }
  }

  drawGround(width, height, middle, ground, scale) {
    const { pen, colours } = this;
    const light = pen.createRadialGradient(middle, ground - 1.1 * scale, 0, middle, ground - 0.9 * scale, Math.max(width, height) * 0.75);
    light.addColorStop(0, css(colours.spot));
    light.addColorStop(1, css(colours.stage));
    pen.fillStyle = light;
    pen.fillRect(0, 0, width, height);
    pen.save();
    pen.translate(middle, ground);
    pen.scale(1, 0.16);
    const pool = pen.createRadialGradient(0, 0, 0, 0, 0, 1.5 * scale);
    pool.addColorStop(0, css(colours.spot));
    pool.addColorStop(1, css(colours.spot, 0));
    pen.fillStyle = pool;
    pen.fillRect(-2 * scale, -2 * scale, 4 * scale, 4 * scale);
    pen.restore();
  }

  drawShadow(points, place) {
    const { pen } = this;
    const there = points.filter(Boolean);
    if (!there.length) return;
    const x = there.reduce((sum, point) => sum + point[0], 0) / there.length;
    const spread = Math.max(0.25, ...there.filter((point) => point[2] < 0.4).map((point) => Math.abs(point[0] - x) + 0.15));
    const [across, down, scale] = place([x, 0, 0]);
    pen.save();
    pen.translate(across, down);
    pen.scale(1, 0.2);
    const dark = pen.createRadialGradient(0, 0, 0, 0, 0, spread * 1.3 * scale);
    dark.addColorStop(0, "rgb(0 0 0 / .38)");
    dark.addColorStop(1, "rgb(0 0 0 / 0)");
    pen.fillStyle = dark;
    pen.fillRect(-2 * scale, -2 * scale, 4 * scale, 4 * scale);
    pen.restore();
  }

  // Parts from far to near; each is wider where the body is, and lit from above.
  drawBody(placed, { bones, trunk, head, back }, strays, metres, { flat, wider = 1 }) {
    const { pen, colours } = this;
    pen.lineCap = pen.lineJoin = "round";
    const parts = [];
    bones.forEach(([a, b], k) => {
      if (!placed[a] || !placed[b] || b === head || k === back) return;
      const long = metres[a] && metres[b] ? Math.hypot(...metres[a].map((value, n) => value - metres[b][n])) : 0.3;
      const wide = Math.min(0.062, Math.max(0.028, 0.15 * long)) * wider;
      const colour = mixed(colours.body, colours.off, straying(strays?.[k]));
      parts.push([(placed[a][3] + placed[b][3]) / 2, () => this.drawLimb(placed[a], placed[b], wide, flat ?? colour)]);
    });
    const corners = trunk.map((place) => placed[place]);
    if (corners.length && corners.every(Boolean)) {
      const colour = mixed(colours.body, colours.off, straying(strays?.[back]));
      parts.push([corners.reduce((sum, one) => sum + one[3], 0) / 4, () => this.drawTrunk(corners, 0.075 * wider, flat ?? colour)]);
    }
    if (head >= 0 && placed[head]) parts.push([placed[head][3], () => this.drawHead(placed[head], corners, 0.115 * wider, flat)]);
    for (const [, drawPart] of parts.sort((one, other) => other[0] - one[0])) drawPart();
  }

  lit(x1, y1, x2, y2, colour) {
    if (typeof colour === "string") return colour;
    const light = this.pen.createLinearGradient(x1, y1, x2, y2);
    light.addColorStop(0, css(mixed(colour, [255, 255, 255], 0.42)));
    light.addColorStop(0.45, css(colour));
    light.addColorStop(1, css(mixed(colour, [0, 0, 0], 0.42)));
    return light;
  }

  // Thinner towards its end, as limbs are.
  drawLimb([x1, y1, s1], [x2, y2, s2], wide, colour) {
    const { pen } = this;
    const [one, two] = [wide * s1 * THICK, wide * s2 * THIN];
    const long = Math.hypot(x2 - x1, y2 - y1) || 1;
    let [nx, ny] = [-(y2 - y1) / long, (x2 - x1) / long];
    if (ny > 0 || (ny === 0 && nx > 0)) [nx, ny] = [-nx, -ny]; // towards the light
    const [x, y, half] = [(x1 + x2) / 2, (y1 + y2) / 2, Math.max(one, two)];
    const along = Math.atan2(y2 - y1, x2 - x1);
    const lean = Math.asin(Math.min(1, Math.max(-1, (one - two) / long))); // of the sides
    pen.fillStyle = this.lit(x + nx * half, y + ny * half, x - nx * half, y - ny * half, colour);
    pen.beginPath();
    pen.arc(x1, y1, one, along + Math.PI / 2 - lean, along - Math.PI / 2 + lean);
    pen.arc(x2, y2, two, along - Math.PI / 2 + lean, along + Math.PI / 2 - lean);
    pen.fill();
  }

  drawTrunk(corners, wide, colour) {
    const { pen } = this;
    const [xs, ys] = [0, 1].map((axis) => corners.map((one) => one[axis]));
    const light = this.lit(Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys), colour);
    pen.beginPath();
    for (const [x, y] of corners) pen.lineTo(x, y);
    pen.closePath();
    pen.fillStyle = pen.strokeStyle = light;
    pen.lineWidth = wide * 1.6 * corners[0][2];
    pen.stroke();
    pen.fill();
  }

  drawHead([x, y, scale], corners, wide, flat) {
    const { pen, colours } = this;
    const radius = wide * scale;
    if (corners.length && corners.every(Boolean)) {
      const neck = [0, 1, 2].map((axis) => (corners[0][axis] + corners[1][axis]) / 2);
      this.drawLimb(neck, [x, y, scale], wide * 0.42, flat ?? colours.body);
    }
    if (flat) {
      pen.fillStyle = flat;
    } else {
      const light = pen.createRadialGradient(x - radius * 0.35, y - radius * 0.45, radius * 0.1, x, y, radius);
      light.addColorStop(0, css(mixed(colours.body, [255, 255, 255], 0.5)));
      light.addColorStop(0.6, css(colours.body));
      light.addColorStop(1, css(mixed(colours.body, [0, 0, 0], 0.4)));
      pen.fillStyle = light;
    }
    pen.beginPath();
    pen.ellipse(x, y, radius * 0.88, radius * 1.12, 0, 0, 7);
    pen.fill();
  }
}
