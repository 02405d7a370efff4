// The search of the theme runs in a worker. Browsers refuse workers in pages that are opened from the
// disk, so a hidden frame takes its place there. Pages from a server keep the worker.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(address) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      frame.title = "search";
      frame.answer = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
      frame.srcdoc =
        "<script>postMessage = (data) => frameElement.answer(data)</script>" +
        `<script src="${address}"></script>`;
      this.loaded = new Promise((done) => {
        frame.addEventListener("load", () => done(frame.contentWindow));
      });
      document.body.append(frame);
    }

    postMessage(data) {
      this.loaded.then((page) => page.dispatchEvent(new MessageEvent("message", { data })));
    }
  };
}
