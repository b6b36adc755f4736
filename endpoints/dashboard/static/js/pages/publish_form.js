/** Form to publish a map, or a new version of one, from its two files. */

import { make, say } from "../dom.js";
import { NAME_OF_MAP, orderForm } from "../order_form.js";

export class PublishForm {
  #name = make("input", { name: "id", placeholder: "hall", ...NAME_OF_MAP });
  #yaml = make("input", { name: "yaml", type: "file", accept: ".yaml,.yml", required: true });
  #image = make("input", { name: "image", type: "file", accept: ".pgm,.png,.bmp,.jpg,.jpeg,.tif,.tiff", required: true });
  #message = make("input", { name: "message", maxLength: 200, placeholder: "The shelf at the dock was moved" });
  #review = make("input", { name: "review", type: "checkbox" });
  #error = make("p", { className: "error", role: "alert" });
  element = make("details", { className: "go" }, make("summary", { textContent: "Publish a map" }));

  /** @param {(form: FormData) => Promise<void>} publish */
  constructor(publish) {
    const files = make("div", { className: "fields" }, make("label", {}, "Name", this.#name), make("label", {}, "YAML file of map_server", this.#yaml),
      make("label", {}, "Image that it names", this.#image), make("label", {}, "Why", this.#message));
    const review = make("label", { className: "check" }, this.#review, "It waits for a review");
    this.element.append(orderForm("Publish a map", "Publish", () => this.#send(publish), files, review, this.#error));
  }

  async #send(publish) {
    say(this.#error, "");
    const form = new FormData();
    form.append("id", this.#name.value.trim());
    form.append("message", this.#message.value);
    if (this.#review.checked) form.append("review", "true");
    for (const input of [this.#yaml, this.#image]) form.append(input.name, input.files[0]);
    try {
      await publish(form);
      this.#yaml.value = this.#image.value = this.#message.value = "";
    } catch (error) {
      say(this.#error, error.message);
    }
  }
}
