// Run by the page that a new browser is sent to: on to the first page, or the one that its
// address names.
location.replace(`/${location.hash}`);
