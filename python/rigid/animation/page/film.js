// The page of a film.
const page = JSON.parse(document.getElementById("film").textContent);
document.title = page.title;
const player = new Player(document.getElementById("player"));
player.show(page.films, page.title);
