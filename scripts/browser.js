// A browser that is driven by lines of JSON on standard input; each is answered by a line on standard output.
//
//   {"open": URL, "scheme": "light" | "dark", "size": [WIDTH, HEIGHT]}   a new page; answers {"page": NUMBER, "process": ID of its browser}
//   {"page": N, "evaluate": JAVASCRIPT}         answers {"value": ...}
//   {"page": N, "click": [X, Y]}
//   {"page": N, "drag": [X, Y, TO_X, TO_Y]}
//   {"page": N, "key": NAME}
//   {"page": N, "picture": FILE.png}
//   {"page": N, "look": [X, Y, WIDTH, HEIGHT]}  answers {"shades": HOW MANY COLOURS, "coloured": SHARE THAT IS NOT GREY}
//   {"page": N, "close": true}
//
// A command that fails is answered with {"error": SENTENCE}. It ends with its standard input.
"use strict";
const { chromium } = require("playwright-core");

const SIZE = [1600, 950];
// Difference between the channels of a pixel, of 255, from which on it is not grey.
const GREY = 40;
const PATIENCE = 120000;

async function look_at(counter, png) {
  return counter.evaluate(async ([base64, grey]) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    const shades = new Set(new Uint32Array(data.buffer)).size;
    let coloured = 0;
    for (let at = 0; at < data.length; at += 4) {
      const [red, green, blue] = data.subarray(at, at + 3);
      if (Math.max(red, green, blue) - Math.min(red, green, blue) > grey) coloured += 1;
    }
    return { shades, coloured: coloured / (data.length / 4) };
  }, [png.toString("base64"), GREY]);
}

async function main() {
  const server = await chromium.launchServer({
    executablePath: process.env.BROWSER_PATH,
    args: [
      "--no-sandbox",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      "--ignore-gpu-blocklist",
      "--disable-quic",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
    ],
  });
  const browser = await chromium.connect(server.wsEndpoint());
  const counter = await browser.newPage();
  const pages = new Map();
  let last = 0;

  async function obey(command) {
    if (command.open) {
      const [width, height] = command.size || SIZE;
      const page = await browser.newPage({ viewport: { width, height }, colorScheme: command.scheme || "light" });
      page.setDefaultTimeout(PATIENCE);
      page.on("pageerror", (error) => console.error(`page error: ${error.message}`));
      page.on("console", (message) => {
        // rerun's program tries to report its use to its maker, which the page forbids.
        const expected = /tel\.rerun\.io|Refused to connect|Failed to fetch/.test(message.text());
        if (message.type() === "error" && !expected) console.error(`console: ${message.text()}`);
      });
      await page.goto(command.open, { waitUntil: "commit" });
      last += 1;
      pages.set(last, page);
      return { page: last, process: server.process().pid };
    }
    const page = pages.get(command.page);
    if (command.evaluate) return { value: (await page.evaluate(command.evaluate)) ?? null };
    if (command.click) await page.mouse.click(...command.click);
    if (command.key) await page.keyboard.press(command.key);
    if (command.drag) {
      const [x, y, to_x, to_y] = command.drag;
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(to_x, to_y, { steps: 8 });
      await page.mouse.up();
    }
    if (command.picture) await page.screenshot({ path: command.picture });
    if (command.look) {
      const [x, y, width, height] = command.look;
      return look_at(counter, await page.screenshot({ clip: { x, y, width, height } }));
    }
    if (command.close) await page.close();
    return {};
  }

  const lines = require("readline").createInterface({ input: process.stdin });
  for await (const line of lines) {
    let answer;
    try {
      answer = await obey(JSON.parse(line));
    } catch (error) {
      answer = { error: error.message };
    }
    process.stdout.write(`${JSON.stringify(answer)}\n`);
  }
  await server.close();
}

main().catch((error) => {
  console.error(error.message);
  process.exit(1);
});
