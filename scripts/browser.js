// A browser that is driven by lines of JSON on standard input; each is answered by a line on standard output.
//
//   {"open": URL, "scheme": "light" | "dark"}   a new page; answers {"page": NUMBER, "process": ID of its browser}
//   {"page": N, "evaluate": JAVASCRIPT}         answers {"value": ...}
//   {"page": N, "click": [X, Y]}
//   {"page": N, "drag": [X, Y, TO_X, TO_Y]}
//   {"page": N, "key": NAME}
//   {"page": N, "picture": FILE.png}
//   {"page": N, "look": [X, Y, WIDTH, HEIGHT]}  answers {"colours": HOW MANY, "commonest": SHARE OF PIXELS}
//   {"page": N, "close": true}
//
// A command that fails is answered with {"error": SENTENCE}. It ends with its standard input.
"use strict";
const { chromium } = require("playwright-core");

const SIZE = { width: 1600, height: 950 };
const PATIENCE = 120000;

async function count_colours(counter, png) {
  return counter.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    const pixels = new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer);
    const counts = new Map();
    for (const pixel of pixels) counts.set(pixel, (counts.get(pixel) || 0) + 1);
    return { colours: counts.size, commonest: Math.max(...counts.values()) / pixels.length };
  }, png.toString("base64"));
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
      const page = await browser.newPage({ viewport: SIZE, colorScheme: command.scheme || "light" });
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
      return count_colours(counter, await page.screenshot({ clip: { x, y, width, height } }));
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
