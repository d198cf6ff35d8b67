// The widget of a notebook: the page of the explorer in a frame. The kernel answers its zooms with finer maps, and lists the
// bodies of a pixel.
const PAUSE = 500;  // ms: a zoom has ended

export default {
  render({model, el}) {
    const frame = document.createElement("iframe");
    frame.title = "map explorer";
    frame.allow = "clipboard-write; fullscreen";
    frame.style.cssText = "width: 100%; height: 720px; border: 0";
    frame.srcdoc = model.get("_page");
    let explorer = null, address = "", timer = null, waiting = null;
    const load = from => explorer?.load(model.get("_content"), from);
    const show = () => {
      address = timer === null ? "" : `#zoom=${explorer?.view}`;  // the reader has zoomed on
      load(address);
    };
    const say = () => explorer?.say(model.get("_said"));
    const zoom = () => {
      timer = null;
      model.set("_region", explorer.region);
      model.save_changes();
    };
    const hear = async ({pixel, zoom: of, bodies, error}) => {
      if (pixel !== waiting?.pixel || of !== explorer.map.zoom) return;
      const {answer} = waiting;
      waiting = null;
      answer(bodies ? explorer.bodiesIn(await explorer.read(bodies), 0) : null);
      if (error) explorer.empty(error);
    };
    frame.onload = async () => {  // and again, where a notebook has moved the frame
      const zooming = timer !== null;
      clearTimeout(timer);
      timer = waiting = null;  // they belong to the page that is gone
      ({explorer} = frame.contentWindow);
      explorer.kept = () => {
        ({address} = explorer);
        clearTimeout(timer);
        timer = setTimeout(zoom, PAUSE);
      };
      explorer.bodiesOf = pixel => new Promise(answer => {
        waiting = {pixel, answer};
        model.send({pixel, zoom: explorer.map.zoom});
      });
      say();
      await load(address);
      if (zooming) explorer.kept();
    };
    const events = [["change:_content", show], ["change:_said", say], ["msg:custom", hear]];
    for (const [name, act] of events) model.on(name, act);
    el.append(frame);
    return () => {
      clearTimeout(timer);
      for (const [name, act] of events) model.off(name, act);
    };
  },
};
