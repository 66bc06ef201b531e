// Frames: what a message of `alight.view.frames.frame` holds, and a canvas that shows it.

const HEADER = 16;

export function frameOf(data) {
  const [picture, width, height, number] = new Uint32Array(data, 0, 4);
  const rgba = new Uint8ClampedArray(data, HEADER);
  return { picture, number, image: new ImageData(rgba, width, height) };
}

export function draw(canvas, image) {
  if (canvas.width !== image.width || canvas.height !== image.height) {
    canvas.width = image.width;
    canvas.height = image.height;
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
}
