"use strict";
// Unpacks what the page carries, and keeps the drawing library to the page's security policy.

/** The text of an element, which is gzip in base64. */
async function unpackText(id) {
  const packed = atob(document.getElementById(id).textContent);
  const bytes = new Uint8Array(packed.length);
  for (let i = 0; i < packed.length; i += 1) bytes[i] = packed.charCodeAt(i);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
}

/** The policy forbids style attributes; the library means no more than the properties in them. */
function setStylesByProperty() {
  const { setAttribute } = Element.prototype;
  Element.prototype.setAttribute = function (name, value) {
    if (name === "style") this.style.cssText = value;
    else setAttribute.call(this, name, value);
  };
}

/** Contexts for 3-D keep what they have drawn, so that it can be copied for paper. */
function keepDrawings() {
  const { getContext } = HTMLCanvasElement.prototype;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return getContext.call(this, kind, kind.startsWith("webgl") ? { ...options, preserveDrawingBuffer: true } : options);
  };
}

/** Run the library, whose text the policy allows by its hash; the styles of its maps, which nothing here uses, are left out. */
async function loadLibrary() {
  const script = document.createElement("script");
  script.textContent = await unpackText("drawing-library");
  setStylesByProperty();
  keepDrawings();
  const { head } = document;
  head.appendChild = (node) => (node.matches("style") && node.textContent ? node : Node.prototype.appendChild.call(head, node));
  document.body.append(script);
  delete head.appendChild;
}
