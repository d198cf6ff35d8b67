// The page of a film.
const page = JSON.parse(document.getElementById("film").textContent);
document.title = page.title;
const player = new Player(document.getElementById("player"));
followTheme(() => {});  // a player looks at each frame whether its paper is dark
player.show(page.films, page.story);
